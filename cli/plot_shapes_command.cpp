// tendril plot shapes: designs folded by either law, side by side over pull.
#include "cli/plot_shapes_command.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/fold_answer.h"
#include "cli/shape_strip.h"
#include "db/files/design_toml.h"
#include "model/fold/facet_chain.h"

namespace tendril::cli {
namespace {

struct ShapesCall {
  std::vector<std::string> designs;
  std::vector<double> pulls = {0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5};
  std::string law = "both";
  std::string file;
};

Result<StripShape> ShapeAt(const std::string& law, const TentacleDesign& design, const TentacleLayout& layout,
                           double pull) {
  StripShape shape{.label = fmt::format("{:.4g}", pull), .facets = {}};
  const Result<FoldAnswer> fold = AnswerFold(law, design, layout, {}, pull);
  if (!fold.ok() && fold.error().kind == ErrorKind::kUnreachable) {
    shape.label += ": beyond reach";
    return shape;
  }
  if (!fold.ok()) return fold.error();
  const FacetChain chain = FoldChain(layout, fold.value().angle);
  for (size_t i = 0; i < layout.facets.size(); ++i) {
    shape.facets.emplace_back(chain.tentacle_from_sheet[i] * layout.facets[i]);
  }
  return shape;
}

Status RunShapes(const ShapesCall& call, Output& out) {
  const std::vector<std::string> laws =
      call.law == "both" ? std::vector<std::string>{"paper", "exact"} : std::vector<std::string>{call.law};
  double length = 0;
  double width = 0;
  std::vector<TentacleDesign> designs;
  for (const std::string& file : call.designs) {
    const auto design = ReadDesign(file);
    if (!design.ok()) return design.error();
    designs.push_back(design.value());
    length = std::max(length, design.value().length);
    width = std::max(width, design.value().base_width * std::max(1.0, design.value().taper));
  }
  const double step = std::max(0.42 * length, 2 * width);
  Figure figure{.columns = static_cast<int>(laws.size()), .panel_width_px = 1250, .panel_height_px = 620};
  for (size_t d = 0; d < designs.size(); ++d) {
    const auto layout = LayOut(designs[d]);
    if (!layout.ok()) return Error(layout.error()).Within(call.designs[d]);
    const std::string name = std::filesystem::path(call.designs[d]).stem().string();
    for (const std::string& law : laws) {
      std::vector<StripShape> shapes;
      for (const double pull : call.pulls) {
        Result<StripShape> shape = ShapeAt(law, designs[d], layout.value(), pull);
        if (!shape.ok()) return Error(shape.error()).Within(call.designs[d]);
        shapes.push_back(std::move(shape).value());
      }
      figure.panels.push_back(StripPanel(fmt::format("{}, law {}: pull", name, law), shapes, step, length));
    }
  }
  if (Status drawn = DrawFigure(figure, call.file); !drawn.ok()) return drawn;
  out.fields()["figure"] = call.file;
  out.Print("{}", call.file);
  return Ok{};
}

}  // namespace

Command MakePlotShapesCommand() {
  auto call = std::make_shared<ShapesCall>();
  return {
      .path = "plot shapes",
      .help = "folded shapes of designs over pull, by either law or both, in one figure",
      .example =
          "tendril plot shapes examples/designs/uniform.toml examples/designs/tapered.toml "
          "examples/designs/bending.toml examples/designs/coiling.toml --out prototypes.png",
      .declare =
          [call](CLI::App& app) {
            app.add_option("designs", call->designs, "design files (TOML)")->required();
            app.add_option("--pulls", call->pulls,
                           "fractions of the tendon's flat length, separated by commas")
                ->delimiter(',')
                ->capture_default_str();
            app.add_option("--law", call->law, "law of the fold angles; both: a column of panels for each")
                ->check(CLI::IsMember({"paper", "exact", "both"}))
                ->capture_default_str();
            app.add_option("--out", call->file, "figure to write (.svg or .png)")->required();
          },
      .run = [call](Output& out) { return RunShapes(*call, out); },
  };
}

}  // namespace tendril::cli
