#include "capture/rig/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/files/safe_file.h"
#include "db/files/toml_read.h"
#include "db/files/toml_write.h"

namespace tendril {
namespace {

struct DistortionName {
  Distortion distortion;
  const char* name;
  size_t coefficients;
};

constexpr DistortionName kDistortions[] = {
    {Distortion::kNone, "none", 0},
    {Distortion::kBrown, "brown", 5},
    {Distortion::kEquidistant, "equidistant", 4},
};

const DistortionName& NameOf(Distortion distortion) {
  return *std::find_if(std::begin(kDistortions), std::end(kDistortions),
                       [&](const DistortionName& d) { return d.distortion == distortion; });
}

// Reads [a, b] into two targets.
void Pair(TomlTable& table, const std::string& key, double& first, double& second, const Bounds& bounds,
          const std::string& expected) {
  std::vector<double> values;
  if (!table.Required().Numbers(key, values, bounds)) return;
  if (values.size() != 2) return table.Reject(key, expected);
  first = values[0];
  second = values[1];
}

void ReadPose(TomlTable& table, Camera& camera) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  const bool placed = table.Required().Vector("position", position, Finite("m"));
  std::vector<double> xyzw;
  if (!table.Required().Numbers("rotation_xyzw", xyzw) || !placed) return;
  Eigen::Quaterniond lab_from_camera;
  if (xyzw.size() == 4) lab_from_camera.coeffs() = Eigen::Vector4d(xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
  if (xyzw.size() != 4 || std::abs(lab_from_camera.norm() - 1) > 1e-3) {
    return table.Reject("rotation_xyzw", "four numbers x, y, z, w of length 1 (lab from camera)");
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = lab_from_camera.normalized().toRotationMatrix();
  pose.translation() = position;
  camera.camera_from_lab = pose.inverse();
}

Camera ReadCamera(TomlTable& table) {
  Camera camera;
  table.Text("name", camera.name);

  double width = 0;
  double height = 0;
  const std::string size_expected = "two whole numbers: width and height in px";
  Pair(table, "image_size_px", width, height, Between(1, 1e6, "px"), size_expected);
  if (width != std::floor(width) || height != std::floor(height))
    table.Reject("image_size_px", size_expected);
  camera.width_px = static_cast<int>(width);
  camera.height_px = static_cast<int>(height);
  Pair(table, "focal_px", camera.focal_x_px, camera.focal_y_px, Above(0, "px"),
       "two numbers: along x and y, px");
  Pair(table, "center_px", camera.center_x_px, camera.center_y_px, Finite("px"),
       "two numbers: x and y of the optical axis, px from the centre of the top left pixel");

  std::string name = "none";
  table.Choice("distortion", name, {"none", "brown", "equidistant"});
  for (const DistortionName& known : kDistortions) {
    if (name == known.name) camera.distortion = known.distortion;
  }
  const size_t most = NameOf(camera.distortion).coefficients;
  std::vector<double> coefficients;
  if (most > 0) table.Required();
  if (table.Numbers("coefficients", coefficients)) {
    const bool four_of_brown = camera.distortion == Distortion::kBrown && coefficients.size() == 4;
    if (coefficients.size() != most && !four_of_brown) {
      table.Reject("coefficients", fmt::format("{} numbers for distortion '{}' ({})", most, name,
                                               most == 5   ? "k1, k2, p1, p2, k3"
                                               : most == 4 ? "k1, k2, k3, k4"
                                                           : "leave them out"));
    } else {
      std::copy(coefficients.begin(), coefficients.end(), camera.coefficients.begin());
    }
  }
  ReadPose(table, camera);
  return camera;
}

}  // namespace

Result<Rig> ParseRig(const std::string& toml, const std::string& name_in_messages) {
  auto document = TomlDocument::Parse(toml, name_in_messages);
  if (!document.ok()) return document.error();
  Rig rig;
  document.value().Root().Text("name", rig.name);
  for (TomlTable& table : document.value().Tables("camera")) {
    rig.cameras.push_back(ReadCamera(table));
    if (rig.cameras.back().name.empty())
      rig.cameras.back().name = fmt::format("cam{}", rig.cameras.size() - 1);
  }
  if (auto s = document.value().Finish(); !s.ok()) return s.error();
  if (rig.cameras.empty()) {
    return Error{ErrorKind::kBadInput, name_in_messages + ": no [[camera]] table; expected one per camera"};
  }
  return rig;
}

Result<Rig> ReadRig(const std::filesystem::path& file) {
  const auto text = ReadText(file);
  if (!text.ok()) return text.error();
  return ParseRig(text.value(), file.string());
}

std::string RigToml(const Rig& rig) {
  const auto list = [](std::initializer_list<double> values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "[" : ", ") + TomlNumber(v + 0.0);  // no -0
    return text + "]";
  };
  std::string text = fmt::format("name = {}\n", TomlText(rig.name));
  for (const Camera& camera : rig.cameras) {
    const Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
    const Eigen::Quaterniond q(lab_from_camera.linear());
    const Eigen::Vector3d p = lab_from_camera.translation();
    const DistortionName& lens = NameOf(camera.distortion);
    text += fmt::format("\n[[camera]]\nname = {}\n", TomlText(camera.name));
    text += fmt::format("image_size_px = [{}, {}]\n", camera.width_px, camera.height_px);
    text += fmt::format("focal_px = {}\n", list({camera.focal_x_px, camera.focal_y_px}));
    text += fmt::format("center_px = {}\n", list({camera.center_x_px, camera.center_y_px}));
    text += fmt::format("distortion = \"{}\"\n", lens.name);
    const auto& k = camera.coefficients;
    if (lens.coefficients == 5)
      text += fmt::format("coefficients = {}\n", list({k[0], k[1], k[2], k[3], k[4]}));
    if (lens.coefficients == 4) text += fmt::format("coefficients = {}\n", list({k[0], k[1], k[2], k[3]}));
    text += fmt::format("position = {}        # of the camera in the lab, m\n", list({p.x(), p.y(), p.z()}));
    text += fmt::format("rotation_xyzw = {}   # lab from camera\n", list({q.x(), q.y(), q.z(), q.w()}));
  }
  return text;
}

}  // namespace tendril
