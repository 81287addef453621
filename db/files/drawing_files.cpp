#include "db/files/drawing_files.h"

#include <fmt/format.h>

#include "db/files/page_text.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

// Ten nanometres, far below a plotter's step, and no -0.
std::string Mm(double metres) {
  const std::string text = fmt::format("{:.5f}", 1e3 * metres);
  return text == "-0.00000" ? "0.00000" : text;
}

const char* CreaseLayer(bool mountain) { return mountain ? "CREASE_M" : "CREASE_V"; }

}  // namespace

std::string CutSvg(const CutPattern& pattern, const std::string& title) {
  const auto at = [&](const Eigen::Vector2d& p) {  // SVG's y points down
    return Mm(p.x()) + "," + Mm(pattern.width - p.y());
  };
  const auto layer = [](const char* name, const char* stroke) {
    return fmt::format(
        "<g id=\"{0}\" inkscape:groupmode=\"layer\" inkscape:label=\"{0}\" fill=\"none\" stroke=\"{1}\" "
        "stroke-width=\"0.1\">\n",
        name, stroke);
  };

  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" "
      "width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} {1}\" overflow=\"visible\">\n<title>{2}</title>\n",
      Mm(pattern.length), Mm(pattern.width), XmlText(title));

  for (const bool mountain : {true, false}) {
    out += layer(CreaseLayer(mountain), mountain ? "#ff0000" : "#0000ff");
    for (const CutCrease& crease : pattern.creases) {
      if (crease.mountain != mountain) continue;
      out += "<path d=\"";
      for (const CutDash& dash : crease.dashes) out += "M" + at(dash.from) + "L" + at(dash.to);
      out += "\"/>\n";
    }
    out += "</g>\n";
  }
  out += layer("HOLE", "#008000");
  for (Eigen::Index i = 0; i < pattern.holes.cols(); ++i) {
    out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", Mm(pattern.holes(0, i)),
                       Mm(pattern.width - pattern.holes(1, i)), Mm(0.5 * pattern.hole_diameter));
  }
  out += "</g>\n" + layer("CUT", "#000000") + "<path d=\"";
  for (Eigen::Index i = 0; i < pattern.outline.cols(); ++i) {
    out += (i == 0 ? "M" : "L") + at(pattern.outline.col(i));
  }
  return out + "Z\"/>\n</g>\n</svg>\n";
}

std::string CutDxf(const CutPattern& pattern) {
  std::string out;
  const auto add = [&](int code, const std::string& value) {
    out += fmt::format("{:>3}\n{}\n", code, value);
  };
  const auto point = [&](int first, const Eigen::Vector2d& p) {
    add(first, Mm(p.x()));
    add(first + 10, Mm(p.y()));
    add(first + 20, "0.0");
  };

  add(999, "lengths in millimetres");
  add(0, "SECTION"), add(2, "HEADER");
  add(9, "$ACADVER"), add(1, "AC1009");
  add(9, "$INSUNITS"), add(70, "4");  // millimetres, for the readers that ask
  add(9, "$EXTMIN"), point(10, {0, 0});
  add(9, "$EXTMAX"), point(10, {pattern.length, pattern.width});
  add(0, "ENDSEC");

  add(0, "SECTION"), add(2, "TABLES");
  add(0, "TABLE"), add(2, "LTYPE"), add(70, "1");
  add(0, "LTYPE"), add(2, "CONTINUOUS"), add(70, "0"), add(3, "Solid line"), add(72, "65"), add(73, "0");
  add(40, "0.0");
  add(0, "ENDTAB");
  add(0, "TABLE"), add(2, "LAYER"), add(70, "4");
  for (const auto& [name, colour] :
       {std::pair{"CUT", "7"}, {"HOLE", "3"}, {"CREASE_M", "1"}, {"CREASE_V", "5"}}) {
    add(0, "LAYER"), add(2, name), add(70, "0"), add(62, colour), add(6, "CONTINUOUS");
  }
  add(0, "ENDTAB"), add(0, "ENDSEC");

  add(0, "SECTION"), add(2, "ENTITIES");
  for (const CutCrease& crease : pattern.creases) {
    for (const CutDash& dash : crease.dashes) {
      add(0, "LINE"), add(8, CreaseLayer(crease.mountain));
      point(10, dash.from), point(11, dash.to);
    }
  }
  for (Eigen::Index i = 0; i < pattern.holes.cols(); ++i) {
    add(0, "CIRCLE"), add(8, "HOLE");
    point(10, pattern.holes.col(i));
    add(40, Mm(0.5 * pattern.hole_diameter));
  }
  add(0, "POLYLINE"), add(8, "CUT"), add(66, "1");
  point(10, {0, 0});
  add(70, "1");  // closed
  for (Eigen::Index i = 0; i < pattern.outline.cols(); ++i) {
    add(0, "VERTEX"), add(8, "CUT");
    point(10, pattern.outline.col(i));
  }
  add(0, "SEQEND"), add(8, "CUT");
  add(0, "ENDSEC"), add(0, "EOF");
  return out;
}

Status WriteCutSvg(const std::filesystem::path& file, const CutPattern& pattern, const std::string& title) {
  return WriteText(file, CutSvg(pattern, title));
}

Status WriteCutDxf(const std::filesystem::path& file, const CutPattern& pattern) {
  return WriteText(file, CutDxf(pattern));
}

}  // namespace tendril
