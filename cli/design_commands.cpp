// tendril design show, design cut: a design's sheet in figures, and as drawings for a plotter.
#include "cli/design_commands.h"

#include <filesystem>
#include <memory>
#include <numbers>

#include "db/files/design_toml.h"
#include "db/files/drawing_files.h"
#include "model/fold/cut_pattern.h"
#include "model/fold/fold.h"

namespace tendril::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Status RunShow(const std::string& file, Output& out) {
  const auto read = ReadDesign(file);
  if (!read.ok()) return read.error();
  const TentacleDesign& design = read.value();
  const auto laid_out = LayOut(design);
  if (!laid_out.ok()) return Error(laid_out.error()).Within(file);
  const TentacleLayout& layout = laid_out.value();

  const Eigen::Index creases = layout.crease_z.size();
  const double b = 2 * layout.half_spacing[0];
  const double c = design.unit_length - b;
  const double tip_width = design.base_width * design.taper;
  const double sheet_width = design.base_width * std::max(1.0, design.taper);
  const double largest_pull = LargestPull(design.closed_angle);

  auto& fields = out.fields();
  fields["design"] = file;
  fields["holes"] = design.holes;
  fields["creases"] = creases;
  fields["facets"] = design.holes;
  fields["sheet_length_m"] = design.length;
  fields["sheet_width_m"] = sheet_width;
  fields["base_width_m"] = design.base_width;
  fields["tip_width_m"] = tip_width;
  fields["first_crease_width_m"] = layout.width[0];
  fields["last_crease_width_m"] = layout.width[creases - 1];
  fields["spacing_b_m"] = b;
  fields["spacing_c_m"] = c;
  fields["end_margin_m"] = -layout.base_z;
  fields["flat_tendon_length_m"] = FlatTendonLength(layout);
  fields["alpha_deg"] = design.alpha / kDegree;
  fields["beta_deg"] = design.beta / kDegree;
  fields["closed_angle_deg"] = design.closed_angle / kDegree;
  fields["largest_pull"] = largest_pull;
  fields["can_be_cut"] = true;

  out.Print("sheet            {:.2f} x {:.2f} mm, {:.3g} mm thick", 1e3 * design.length, 1e3 * sheet_width,
            1e3 * design.thickness);
  out.Print("width            {:.2f} mm at the base, {:.2f} mm at the tip (taper {:.4g})",
            1e3 * design.base_width, 1e3 * tip_width, design.taper);
  out.Print("holes            {} of {:.2f} mm, one per facet", design.holes, 1e3 * design.hole_diameter);
  out.Print("spacing          b {:.3f} mm, c {:.3f} mm in turn (c / b {:.4g}); {:.2f} mm left at either end",
            1e3 * b, 1e3 * c, design.spacing_ratio, -1e3 * layout.base_z);
  out.Print("creases          {}, at {:.4g} and {:.4g} degrees in turn; {:.2f} to {:.2f} mm wide", creases,
            design.alpha / kDegree, design.beta / kDegree, 1e3 * layout.width[0],
            1e3 * layout.width[creases - 1]);
  out.Print("tendon           {:.2f} mm hole to hole when flat", 1e3 * FlatTendonLength(layout));
  out.Print("largest pull     {:.6g}: every crease closed at {:.4g} degrees", largest_pull,
            design.closed_angle / kDegree);
  for (const std::string& reason : WhyNotCut(design, layout)) {
    fields["can_be_cut"] = false;
    out.Warn("cannot be cut: " + reason);
  }
  return Ok{};
}

struct CutCall {
  std::string design;
  std::string svg;
  std::string dxf;
  double dash_mm = 1;
  double gap_mm = 1;
};

Status RunCut(const CutCall& call, Output& out) {
  if (call.svg.empty() && call.dxf.empty()) {
    return Error{ErrorKind::kBadInput, "nothing to write: give --svg FILE, --dxf FILE or both"};
  }
  const auto design = ReadDesign(call.design);
  if (!design.ok()) return design.error();
  const auto pattern = CutPatternOf(design.value(), {.dash = 1e-3 * call.dash_mm, .gap = 1e-3 * call.gap_mm});
  if (!pattern.ok()) return Error(pattern.error()).Within(call.design);

  auto& fields = out.fields();
  fields["design"] = call.design;
  fields["sheet_length_m"] = pattern.value().length;
  fields["sheet_width_m"] = pattern.value().width;
  fields["creases"] = pattern.value().creases.size();
  fields["holes"] = pattern.value().holes.cols();
  fields["dash_m"] = 1e-3 * call.dash_mm;
  fields["gap_m"] = 1e-3 * call.gap_mm;
  const std::string title = std::filesystem::path(call.design).stem().string();
  if (!call.svg.empty()) {
    if (Status done = WriteCutSvg(call.svg, pattern.value(), title); !done.ok()) return done;
    fields["svg"] = call.svg;
    out.Print("{}: {:.2f} x {:.2f} mm, layers CUT, HOLE, CREASE_M, CREASE_V", call.svg,
              1e3 * pattern.value().length, 1e3 * pattern.value().width);
  }
  if (!call.dxf.empty()) {
    if (Status done = WriteCutDxf(call.dxf, pattern.value()); !done.ok()) return done;
    fields["dxf"] = call.dxf;
    out.Print("{}: DXF R12 in millimetres, layers CUT, HOLE, CREASE_M, CREASE_V", call.dxf);
  }
  return Ok{};
}

}  // namespace

Command MakeDesignShowCommand() {
  auto design = std::make_shared<std::string>();
  return {
      .path = "design show",
      .help = "what a design comes to: counts, spacing, widths, largest pull, and whether it can be cut",
      .example = "tendril design show examples/designs/paper.toml",
      .declare =
          [design](CLI::App& app) { app.add_option("design", *design, "design file (TOML)")->required(); },
      .run = [design](Output& out) { return RunShow(*design, out); },
  };
}

Command MakeDesignCutCommand() {
  auto call = std::make_shared<CutCall>();
  return {
      .path = "design cut",
      .help = "cut pattern of one tentacle for a plotter: outline, perforated creases, holes",
      .example = "tendril design cut examples/designs/paper.toml --svg paper.svg --dxf paper.dxf",
      .declare =
          [call](CLI::App& app) {
            app.add_option("design", call->design, "design file (TOML)")->required();
            app.add_option("--svg", call->svg, "write an SVG file (millimetres, a group per layer)");
            app.add_option("--dxf", call->dxf, "write a DXF R12 file (millimetres)");
            app.add_option("--dash-mm", call->dash_mm, "cut part of a perforation, mm")
                ->capture_default_str();
            app.add_option("--gap-mm", call->gap_mm, "part left standing, mm")->capture_default_str();
          },
      .run = [call](Output& out) { return RunCut(*call, out); },
  };
}

}  // namespace tendril::cli
