#include "model/fold/design.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::string Number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 12);
  return {text, end.ptr};
}

Error OutOfRange(const std::string& field, double value, const std::string& expected) {
  return {ErrorKind::kBadInput, field + " = " + Number(value) + ": expected " + expected};
}

// Comparisons are written so that NaN fails them.
bool Positive(double value) { return value > 0 && std::isfinite(value); }

// Where crease (centre z, angle a) meets the ribbon's edge y = side * width / 2, width changing by `slope`
// per metre of z. A crease so oblique that it leaves through a cut end stops there, inside the edge.
Eigen::Vector3d CreaseEnd(double z, double angle, double width, double slope, int side, double base_z,
                          double tip_z) {
  const double sine = std::sin(angle);
  const double cosine = std::cos(angle);
  const double steepness = sine - side * 0.5 * slope * cosine;
  double along = steepness > 0 ? side * 0.5 * width / steepness : side * HUGE_VAL;
  const double room = along * cosine > 0 ? tip_z - z : base_z - z;  // signed distance to the end ahead
  if (std::abs(along * cosine) > std::abs(room)) along = room / cosine;
  return {0, along * sine, z + along * cosine};
}

}  // namespace

Status CheckDesign(const TentacleDesign& design) {
  const struct {
    const char* field;
    double value;
  } positive[] = {{"length", design.length},
                  {"base_width", design.base_width},
                  {"taper", design.taper},
                  {"unit_length", design.unit_length},
                  {"spacing_ratio", design.spacing_ratio},
                  {"hole_diameter", design.hole_diameter},
                  {"thickness", design.thickness},
                  {"youngs_modulus", design.youngs_modulus},
                  {"crease_length", design.crease_length},
                  {"stiffness_ratio", design.stiffness_ratio}};
  for (const auto& [field, value] : positive) {
    if (!Positive(value)) return OutOfRange(field, value, "a finite number above 0");
  }
  const struct {
    const char* field;
    double value;
  } angles[] = {{"alpha_deg", design.alpha}, {"beta_deg", design.beta}};
  for (const auto& [field, value] : angles) {
    if (!(value > 0 && value < std::numbers::pi)) {
      return OutOfRange(field, value / kDegree, "an angle between 0 and 180, both excluded");
    }
  }
  if (!(design.holes >= 2 && design.holes <= 1'000'000)) {
    return OutOfRange("holes", design.holes, "2 to 1000000");
  }
  // A right angle typed in degrees may arrive a rounding error above pi/2.
  if (!(design.closed_angle > 0 && design.closed_angle <= std::numbers::pi / 2 + 1e-12)) {
    return OutOfRange("closed_angle_deg", design.closed_angle / kDegree, "above 0, up to 90");
  }
  if (!(std::abs(design.rest_angle) < std::numbers::pi / 2)) {
    return OutOfRange("rest_angle_deg", design.rest_angle / kDegree, "between -90 and 90, both excluded");
  }
  if (!(std::abs(design.stiffness_exponent) <= 10)) {
    return OutOfRange("stiffness_exponent", design.stiffness_exponent, "-10 to 10");
  }
  if (!(design.tendon_friction >= 0 && std::isfinite(design.tendon_friction))) {
    return OutOfRange("friction", design.tendon_friction, "a finite number, 0 or above");
  }
  if (!(design.wrap_angle >= 0 && design.wrap_angle <= std::numbers::pi)) {
    return OutOfRange("wrap_angle_deg", design.wrap_angle / kDegree, "0 to 180");
  }
  return Ok{};
}

Result<TentacleLayout> LayOut(const TentacleDesign& design) {
  if (Status checked = CheckDesign(design); !checked.ok()) return std::move(checked).error();

  const int holes = design.holes;
  const int creases = holes - 1;
  const double b = design.unit_length / (1 + design.spacing_ratio);
  const double c = design.unit_length - b;

  TentacleLayout layout;
  layout.hole_z.resize(holes);
  layout.crease_z.resize(creases);
  layout.crease_angle.resize(creases);
  layout.half_spacing.resize(creases);
  layout.width.resize(creases);
  layout.stiffness.resize(creases);
  // Each place from its number, not by adding up spacings: no error grows along the tentacle.
  const auto hole_at = [&](int i) {
    const int units = i / 2;
    return units * design.unit_length + (i % 2) * b;
  };
  for (int i = 0; i < holes; ++i) layout.hole_z[i] = hole_at(i);
  const double used = layout.hole_z[holes - 1];
  if (used > design.length * (1 + 1e-12)) {
    return Error{ErrorKind::kBadInput,
                 "holes = " + std::to_string(holes) + " at unit_length = " + Number(design.unit_length) +
                     " m need " + Number(used) + " m: expected at most length = " + Number(design.length) +
                     " m; take fewer holes, a shorter unit or a longer sheet"};
  }
  layout.base_z = -0.5 * std::max(0.0, design.length - used);
  layout.tip_z = used - layout.base_z;

  for (int i = 0; i < creases; ++i) {
    const bool is_alpha = i % 2 == 0;
    layout.half_spacing[i] = 0.5 * (is_alpha ? b : c);
    layout.crease_z[i] = layout.hole_z[i] + layout.half_spacing[i];
    layout.crease_angle[i] = is_alpha ? design.alpha : design.beta;
    layout.width[i] = WidthAt(design, layout, layout.crease_z[i]);
    layout.stiffness[i] = std::pow(layout.width[i] / design.base_width, design.stiffness_exponent) *
                          (is_alpha ? 1.0 : design.stiffness_ratio);
  }

  // Corner pairs (y < 0, y > 0) from the base to the tip: cut end, creases, cut end.
  const double slope = design.base_width * (design.taper - 1) / design.length;
  std::vector<Eigen::Matrix<double, 3, 2>> across(creases + 2);
  across.front() << 0, 0, -0.5 * design.base_width, 0.5 * design.base_width, layout.base_z, layout.base_z;
  const double tip_width = design.base_width * design.taper;
  across.back() << 0, 0, -0.5 * tip_width, 0.5 * tip_width, layout.tip_z, layout.tip_z;
  for (int i = 0; i < creases; ++i) {
    for (const int side : {-1, 1}) {
      across[i + 1].col(side < 0 ? 0 : 1) =
          CreaseEnd(layout.crease_z[i], layout.crease_angle[i], layout.width[i], slope, side, layout.base_z,
                    layout.tip_z);
    }
  }
  layout.facets.resize(holes);
  for (int i = 0; i < holes; ++i) {
    layout.facets[i].resize(3, 4);
    layout.facets[i] << across[i].col(0), across[i].col(1), across[i + 1].col(1), across[i + 1].col(0);
  }
  return layout;
}

double WidthAt(const TentacleDesign& design, const TentacleLayout& layout, double z) {
  return design.base_width * (1 + (design.taper - 1) * ((z - layout.base_z) / design.length));
}

TentacleDesign Mirrored(TentacleDesign design) {
  design.alpha = std::numbers::pi - design.alpha;
  design.beta = std::numbers::pi - design.beta;
  return design;
}

double FlatTendonLength(const TentacleLayout& layout) { return 2 * layout.half_spacing.sum(); }

}  // namespace tendril
