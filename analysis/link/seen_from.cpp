#include "analysis/link/seen_from.h"

#include "model/check.h"

namespace tendril {

std::vector<CurveSeries> SeenFrom(std::span<const Eigen::Isometry3d> lab_from_object,
                                  std::span<const CurveSeries> curves) {
  std::vector<CurveSeries> seen;
  for (const CurveSeries& one : curves) {
    TENDRIL_CHECK(one.curves.size() == lab_from_object.size());
    CurveSeries& moved = seen.emplace_back();
    moved.name = one.name;
    moved.time = one.time;
    for (std::size_t f = 0; f < one.curves.size(); ++f) {
      const Eigen::Isometry3d back = lab_from_object.front() * lab_from_object[f].inverse();
      FramedCurve& curve = moved.curves.emplace_back();
      curve.points = (back.linear() * one.curves[f].points).colwise() + back.translation();
      curve.normals = back.linear() * one.curves[f].normals;
    }
  }
  return seen;
}

}  // namespace tendril
