#include "capture/rig/tag_family.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

namespace tendril {
namespace {

struct Maker {
  const char* name;
  apriltag_family* (*create)();
  void (*destroy)(apriltag_family*);
};

constexpr Maker kMakers[] = {
    {"tag36h11", tag36h11_create, tag36h11_destroy},
    {"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    {"tag25h9", tag25h9_create, tag25h9_destroy},
    {"tag16h5", tag16h5_create, tag16h5_destroy},
    {"tag36h10", tag36h10_create, tag36h10_destroy},
    {"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
    {"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    {"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    {"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
};

const Maker* Find(const std::string& name) {
  for (const Maker& maker : kMakers) {
    if (name == maker.name) return &maker;
  }
  return nullptr;
}

// Side of the largest square around the middle without a bit, modules.
int VoidWidth(const apriltag_family& family) {
  const double middle = 0.5 * family.width_at_border;  // bits' places count from the border's corner
  double nearest = family.total_width;
  for (uint32_t i = 0; i < family.nbits; ++i) {
    const double x = std::abs(static_cast<double>(family.bit_x[i]) + 0.5 - middle);
    const double y = std::abs(static_cast<double>(family.bit_y[i]) + 0.5 - middle);
    nearest = std::min(nearest, std::max(x, y));
  }
  return std::max(0, static_cast<int>(std::lround(2 * nearest)) - 1);
}

using Owned = std::unique_ptr<apriltag_family, void (*)(apriltag_family*)>;

Error Unknown(const std::string& name) {
  return {ErrorKind::kBadInput, fmt::format("tag family '{}' is not known; expected one of {}", name,
                                            fmt::join(TagFamilyNames(), ", "))};
}

}  // namespace

std::vector<std::string> TagFamilyNames() {
  std::vector<std::string> names;
  for (const Maker& maker : kMakers) names.emplace_back(maker.name);
  return names;
}

apriltag_family* CreateFamily(const std::string& name) {
  const Maker* maker = Find(name);
  return maker != nullptr ? maker->create() : nullptr;
}

void DestroyFamily(apriltag_family* family) {
  if (family == nullptr) return;
  if (const Maker* maker = Find(family->name)) maker->destroy(family);
}

Result<TagFamily> FamilyOf(const std::string& name) {
  const Owned family(CreateFamily(name), DestroyFamily);
  if (!family) return Unknown(name);
  return TagFamily{.name = name,
                   .ids = static_cast<int>(family->ncodes),
                   .bits = static_cast<int>(family->nbits),
                   .hamming = static_cast<int>(family->h),
                   .border_width = family->width_at_border,
                   .total_width = family->total_width,
                   .void_width = VoidWidth(*family),
                   .round = name.starts_with("tagCircle"),
                   .reversed_border = family->reversed_border};
}

Result<TagPattern> PatternOf(const std::string& name, int id) {
  const Owned family(CreateFamily(name), DestroyFamily);
  if (!family) return Unknown(name);
  if (id < 0 || id >= static_cast<int>(family->ncodes)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{} has no tag {}; expected 0 to {}", name, id, family->ncodes - 1)};
  }
  image_u8_t* image = apriltag_to_image(family.get(), id);
  TagPattern pattern(image->height, image->width);
  for (int row = 0; row < image->height; ++row) {
    for (int column = 0; column < image->width; ++column) {
      pattern(row, column) = image->buf[row * image->stride + column];
    }
  }
  image_u8_destroy(image);
  return pattern;
}

}  // namespace tendril
