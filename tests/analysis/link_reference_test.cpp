// analysis/link against the simulator that the paper used: twist, writhe, self-link and link of eleven open
// curves, at that program's own finite closures.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/link/link.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// The last three numbers of each row, by the curve number in its first column.
std::map<int, Matrix3Xd> ReadColumns(const std::filesystem::path& file) {
  std::map<int, std::vector<Vector3d>> rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    const size_t n = cells.size();
    rows[std::stoi(cells[0])].emplace_back(std::stod(cells[n - 3]), std::stod(cells[n - 2]),
                                           std::stod(cells[n - 1]));
  }
  std::map<int, Matrix3Xd> curves;
  for (const auto& [curve, points] : rows) {
    Matrix3Xd& out = curves[curve];
    out.resize(3, static_cast<Eigen::Index>(points.size()));
    for (size_t i = 0; i < points.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return curves;
}

struct Reference {
  std::map<int, Matrix3Xd> points;   // 101 nodes each
  std::map<int, Matrix3Xd> normals;  // of the 100 elements
  nlohmann::json values;
};

Reference ReadReference(const std::filesystem::path& folder) {
  Reference reference{ReadColumns(folder / "R7_curves.csv"), ReadColumns(folder / "R7_normals.csv"), {}};
  std::ifstream(folder / "R7_link.json") >> reference.values;
  return reference;
}

// "next_tangent_x10L" -> next_tangent:10.
Closure ClosureOf(const std::string& key) {
  if (key == "no_extension") return {ClosureKind::kNone, 0};
  const size_t at = key.rfind("_x");
  return ParseClosure(key.substr(0, at) + ":" + key.substr(at + 2, key.size() - at - 3)).value();
}

// The same shape with a node in the middle of each segment that carries the element's normal; at the old
// nodes the normal of the element before, carried over half the turn. All twist then lies where the elements'
// frames meet.
FramedCurve WithElementNormals(const Matrix3Xd& points, const Matrix3Xd& elements) {
  const Eigen::Index n = elements.cols();
  FramedCurve curve{Matrix3Xd(3, 2 * n + 1), Matrix3Xd(3, 2 * n + 1)};
  for (Eigen::Index i = 0; i <= n; ++i) {
    curve.points.col(2 * i) = points.col(i);
    curve.normals.col(2 * i) = elements.col(std::max<Eigen::Index>(i - 1, 0));
    if (i > 0 && i < n) {
      const Vector3d before = (points.col(i) - points.col(i - 1)).normalized();
      const Vector3d after = (points.col(i + 1) - points.col(i)).normalized();
      const Eigen::Quaterniond half =
          Eigen::Quaterniond::FromTwoVectors(before, (before + after).normalized());
      const Vector3d across = elements.col(i - 1) - elements.col(i - 1).dot(before) * before;
      curve.normals.col(2 * i) = half * across;
    }
    if (i == n) continue;
    curve.points.col(2 * i + 1) = 0.5 * (points.col(i) + points.col(i + 1));
    curve.normals.col(2 * i + 1) = elements.col(i);
  }
  return curve;
}

// Not compared: the peer's net_tangent is another direction than the mean of the unit tangents; and its
// writhe at end_to_end:1, where both straight ends lie on one line and its unclamped arcsines lose up to 0.7
// turns (at 10 and more arc lengths the two programs agree). Its arcsines are good for 8e-9 elsewhere.
bool Comparable(const std::string& key) { return key.rfind("net_tangent", 0) != 0; }

class PeerLink : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing_support::SharedFolder() / "reference";
    TENDRIL_SKIP_WITHOUT(folder_ / "R7_link.json");
    reference_ = ReadReference(folder_);
  }
  std::filesystem::path folder_;
  Reference reference_;
};

TEST_F(PeerLink, AllPairValues) {
  int count = 0;
  double worst = 0;
  for (const auto& pair : reference_.values["pairs"]) {
    const Matrix3Xd& a = reference_.points[pair["i"]];
    const Matrix3Xd& b = reference_.points[pair["j"]];
    for (const auto& [key, value] : pair["link"].items()) {
      const Strand first = CloseCurve(a, ClosureOf(key)).value(),
                   second = CloseCurve(b, ClosureOf(key)).value();
      const LinkValue fast = StrandLink(first, second, LinkMethod::kFast);
      const LinkValue exact = StrandLink(first, second, LinkMethod::kExact);
      EXPECT_NEAR(exact.value, value.get<double>(), 2.4e-9) << pair["i"] << " " << pair["j"] << " " << key;
      EXPECT_NEAR(fast.value, exact.value, 1e-12) << pair["i"] << " " << pair["j"] << " " << key;
      worst = std::max(worst, std::abs(exact.value - value.get<double>()));
      ++count;
    }
  }
  EXPECT_EQ(count, 275);
  std::printf("275 pair values, largest difference %.3g\n", worst);
}

TEST_F(PeerLink, TwistAndWrithe) {
  double worst_twist = 0, worst_writhe = 0;
  for (const auto& curve : reference_.values["curves"]) {
    const int k = curve["curve"];
    const FramedCurve fine = WithElementNormals(reference_.points[k], reference_.normals[k]);
    const auto normals = PerpendicularNormals(fine, false);
    ASSERT_TRUE(normals.ok()) << normals.error().message;
    const double twist = Twist(fine.points, normals.value(), false);
    EXPECT_NEAR(twist, curve["twist"].get<double>(), 1e-9) << "curve " << k;
    worst_twist = std::max(worst_twist, std::abs(twist - curve["twist"].get<double>()));
    for (const auto& [key, value] : curve["writhe"].items()) {
      if (!Comparable(key) || key == "end_to_end_x1L") continue;
      const double writhe = StrandWrithe(CloseCurve(reference_.points[k], ClosureOf(key)).value()).value;
      EXPECT_NEAR(writhe, value.get<double>(), 1e-8) << "curve " << k << " " << key;
      worst_writhe = std::max(worst_writhe, std::abs(writhe - value.get<double>()));
    }
  }
  std::printf("largest difference: twist %.3g, writhe %.3g\n", worst_twist, worst_writhe);
}

TEST_F(PeerLink, SelfLinkWithTheOffsetCurve) {
  const double offset = reference_.values["radius_aux"];
  double worst = 0;
  for (const auto& curve : reference_.values["curves"]) {
    const int k = curve["curve"];
    const Matrix3Xd& points = reference_.points[k];
    Matrix3Xd beside = points;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {  // node i > 0 takes the normal of element i - 1
      const Eigen::Index element = std::max<Eigen::Index>(i - 1, 0);
      const Vector3d tangent = (points.col(element + 1) - points.col(element)).normalized();
      const Vector3d normal = reference_.normals[k].col(element);
      beside.col(i) += offset * (normal - normal.dot(tangent) * tangent).normalized();
    }
    for (const auto& [key, value] : curve["selflink"].items()) {
      if (!Comparable(key)) continue;
      const Strand strand = CloseCurve(points, ClosureOf(key)).value();
      const LinkValue link = OffsetLink(strand, CloseLike(strand, beside));
      EXPECT_NEAR(link.value, value.get<double>(), 1e-8) << "curve " << k << " " << key;
      worst = std::max(worst, std::abs(link.value - value.get<double>()));
    }
  }
  std::printf("largest difference: self-link %.3g\n", worst);
}

}  // namespace
}  // namespace tendril
