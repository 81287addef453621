#include "capture/rig/tag_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/rig/tag_views.h"

namespace tendril {
namespace {

constexpr double kMostFalse = 1e-3;
constexpr double kMuchLarger = 1.25;

// Whether a is the better choice.
bool Better(const FamilyOption& a, const FamilyOption& b, std::optional<double> m_per_px) {
  if (m_per_px) {
    const bool a_read = a.module / *m_per_px >= DecodeLimitPx(0);
    const bool b_read = b.module / *m_per_px >= DecodeLimitPx(0);
    if (a_read != b_read) return a_read;
  }
  if (a.module > kMuchLarger * b.module) return true;
  if (b.module > kMuchLarger * a.module) return false;
  if (a.family.reversed_border != b.family.reversed_border) return !a.family.reversed_border;
  if (std::abs(a.module - b.module) > 1e-9) return a.module > b.module;
  return a.false_tags < b.false_tags;
}

std::string WhyOf(const FamilyOption& chosen, const std::vector<FamilyOption>& options) {
  std::string why = fmt::format("{} has {} ids for {} tags and modules of {:.3g} mm", chosen.family.name,
                                chosen.family.ids, chosen.tags, 1e3 * chosen.module);
  why += chosen.family.reversed_border
             ? ", the largest that do (its border is light on dark: `track` keeps the library's corners)"
             : ", and its dark border lets `track` fit the corners";
  std::string few;
  for (const FamilyOption& option : options) {
    if (option.enough_ids || option.tags == 0) continue;
    few += fmt::format("{}{} {}", few.empty() ? "" : ", ", option.family.name, option.family.ids);
  }
  return few.empty() ? why : fmt::format("{}; too few ids: {}", why, few);
}

}  // namespace

double FalseTagShare(const TagFamily& family) {
  const double bits = family.bits;
  const double words = family.ids > 10000 ? 1 + bits : 1 + bits + bits * (bits - 1) / 2;
  return 4.0 * family.ids * words / std::exp2(bits);
}

Result<FamilyChoice> ChooseFamily(const TentacleDesign& design, const Gripper& gripper,
                                  const TagLayoutOptions& options, std::optional<double> m_per_px) {
  FamilyChoice choice;
  const FamilyOption* best = nullptr;
  std::optional<Error> last;
  for (const std::string& name : TagFamilyNames()) {
    const auto family = FamilyOf(name);
    if (!family.ok()) return family.error();
    if (family.value().round) continue;
    FamilyOption option{.family = family.value(), .false_tags = FalseTagShare(family.value())};
    TagLayoutOptions own = options;
    own.family = name;
    own.over_hole = options.over_hole && family.value().void_width > 0;
    // A size that no family's tag could have is the same error for all; ids are counted first.
    TagLayoutOptions roomy = own;
    roomy.family = own.over_hole ? name : "tagStandard52h13";
    roomy.first_id = 0;
    const auto layout = LayOutTags(design, gripper, roomy);
    if (!layout.ok()) {
      last = layout.error();
    } else {
      option.tags = static_cast<int>(layout.value().tags.size());
      option.module = SmallestFootprint(layout.value()) / family.value().total_width;
      option.enough_ids = options.first_id + option.tags <= family.value().ids;
    }
    choice.options.push_back(option);
  }
  for (const FamilyOption& option : choice.options) {
    if (!option.enough_ids || option.false_tags > kMostFalse) continue;
    if (best == nullptr || Better(option, *best, m_per_px)) best = &option;
  }
  if (best == nullptr && last) return *last;
  if (best == nullptr) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("no family has ids {} to {}; expected fewer tentacles, facets or sides",
                             options.first_id, options.first_id + choice.options.front().tags - 1)};
  }
  choice.family = best->family.name;
  choice.why = WhyOf(*best, choice.options);
  return choice;
}

}  // namespace tendril
