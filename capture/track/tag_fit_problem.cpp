#include "capture/track/tag_fit_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tendril::tag_fit {

std::optional<Eigen::Matrix<double, 8, 1>> HomographyTo(const Corners& corners) {
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const double x = kCornerX[i], y = kCornerY[i], u = corners(0, i), v = corners(1, i);
    a.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * i) << u, v;
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, 8, 8>> lu(a);
  if (!lu.isInvertible()) return std::nullopt;
  const Eigen::Matrix<double, 8, 1> h = lu.solve(b);
  // The whole tag lies before the camera.
  for (int i = 0; i < 4; ++i) {
    if (!(h[6] * kCornerX[i] + h[7] * kCornerY[i] + 1 > 0.2)) return std::nullopt;
  }
  return h;
}

Eigen::Matrix3d Matrix(const Unknowns& x) {
  Eigen::Matrix3d m;
  m << x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], 1;
  return m;
}

Corners CornersOf(const Unknowns& x) {
  Corners corners;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = Matrix(x) * Eigen::Vector3d(kCornerX[i], kCornerY[i], 1);
    corners.col(i) = p.head<2>() / p.z();
  }
  return corners;
}

namespace {

Eigen::Matrix2d BlurOf(const Unknowns& x, const Eigen::Matrix3d& tag_from_pixel, double half, double blur) {
  // The middle of the tag stands for all of it.
  const Eigen::Matrix3d& g = tag_from_pixel;
  const double d = 1 / (g(2, 0) * x[2] + g(2, 1) * x[5] + g(2, 2));
  Eigen::Matrix2d j;
  j << g(0, 0) * d, g(0, 1) * d, g(1, 0) * d, g(1, 1) * d;
  return (half * half * blur * blur) * j * j.transpose();
}
bool IsFine(const Eigen::Matrix2d& blur) {
  return blur.allFinite() && blur(0, 0) < 4 && blur(1, 1) < 4 && blur(0, 0) > 1e-4 && blur(1, 1) > 1e-4;
}

// A row of the Jacobian: how what a pixel sees changes with the unknowns. The pattern moves under the pixel:
// gray by pixel, then pixel by homography with its sign turned.
//   g       tag_from_pixel
//   tx, ty  where the pixel is in the tag; s the inverse of its depth there
template <class S, class Seen>
inline void RowOf(const S* x, const S* g, S half, S px, S py, S tx, S ty, S s, const Seen& seen, S* row) {
  const S d = 1 / s;
  const S by_tx = half * d * (x[kWhite] * seen.by_u + x[kSurround] * seen.surround_by_u);
  const S by_ty = half * d * (x[kWhite] * seen.by_v + x[kSurround] * seen.surround_by_v);
  const S by_x = by_tx * (g[0] - tx * g[6]) + by_ty * (g[3] - ty * g[6]);
  const S by_y = by_tx * (g[1] - tx * g[7]) + by_ty * (g[4] - ty * g[7]);
  const S cx = -s * by_x, cy = -s * by_y;
  const S bend = -(cx * px + cy * py);
  const S all[kUnknowns] = {cx * tx,   cx * ty,   cx, cy * tx,    cy * ty,       cy,
                            bend * tx, bend * ty, 1,  seen.white, seen.surround, x[kWhite] * seen.by_blur};
  std::copy_n(all, kUnknowns, row);
}

// By TagSeer in double precision.
class PlainProblem : public Problem {
 public:
  using Problem::Problem;

  void StartContrast(Unknowns& x) const override {
    const Eigen::Matrix3d g = Matrix(x).inverse();
    const Eigen::Matrix2d blur = BlurOf(x, g, half_, std::exp(x[kBlur]));
    if (!IsFine(blur)) return;
    const TagSeer seer(look_, blur);
    Eigen::Matrix3d normals = Eigen::Vector3d(0, 0, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Pixel& p : pixels_) {
      const double d = half_ / (g(2, 0) * p.x + g(2, 1) * p.y + g(2, 2));
      const SeenTag seen = seer.See(d * (g(0, 0) * p.x + g(0, 1) * p.y + g(0, 2)) + 0.5 * look_.modules,
                                    d * (g(1, 0) * p.x + g(1, 1) * p.y + g(1, 2)) + 0.5 * look_.modules);
      const Eigen::Vector3d j(1, seen.white, seen.surround);
      normals += j * j.transpose();
      right += p.gray * j;
    }
    x.segment<3>(kBlack) = normals.ldlt().solve(right);
  }

  double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) override {
    const Eigen::Matrix3d inverse = Matrix(x).inverse();
    const Eigen::Matrix2d blur = BlurOf(x, inverse, half_, std::exp(x[kBlur]));
    if (!IsFine(blur)) return std::numeric_limits<double>::infinity();
    const TagSeer seer(look_, blur);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = inverse;
    const double* const g = rows.data();
    normals.setZero();
    gradient.setZero();
    double cost = Prior(x, normals, gradient);
    Unknowns j;
    for (const Pixel& p : pixels_) {
      const double s = g[6] * p.x + g[7] * p.y + g[8];
      const double tx = (g[0] * p.x + g[1] * p.y + g[2]) / s, ty = (g[3] * p.x + g[4] * p.y + g[5]) / s;
      const SeenTag seen = seer.See(tx * half_ + 0.5 * look_.modules, ty * half_ + 0.5 * look_.modules);
      const double residual = x[kBlack] + x[kWhite] * seen.white + x[kSurround] * seen.surround - p.gray;
      cost += residual * residual;
      RowOf(x.data(), g, half_, p.x, p.y, tx, ty, s, seen, j.data());
      normals.selfadjointView<Eigen::Lower>().rankUpdate(j);
      gradient += residual * j;
    }
    normals.triangularView<Eigen::StrictlyUpper>() = normals.transpose();
    return cost;
  }
};

// By a TagTable in single precision.
class TableProblem : public Problem {
 public:
  TableProblem(const TagLook& look, const std::vector<Pixel>& pixels, const TagFitOptions& options,
               TagFollow& follow)
      : Problem(look, pixels, options),
        follow_(follow),
        rows_(kUnknowns + 1, static_cast<Eigen::Index>(pixels.size())) {}

  // Makes the table anew where it must; false: the tag is degenerate.
  bool Prepare(const Unknowns& x) {
    const Eigen::Matrix2d blur = BlurOf(x, Matrix(x).inverse(), half_, options_.blur_px);
    if (!IsFine(blur)) return false;
    if (!follow_.table.Serves(blur)) follow_.table.Make(look_, blur);
    if (follow_.white - follow_.black > 0) ComeNear();
    return true;
  }

  void StartContrast(Unknowns& x) const override {
    Eigen::Matrix3d normals = Eigen::Vector3d(0, 0, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    if (follow_.white - follow_.black > 0) {
      x.segment<3>(kBlack) << follow_.black, follow_.white - follow_.black, follow_.surround - follow_.black;
      return;
    }
    ForEach(x, [&](const Pixel& p, float, float, float, const TagTable::Seen& seen) {
      const Eigen::Vector3d j(1, seen.white, seen.surround);
      normals += j * j.transpose();
      right += p.gray * j;
    });
    x.segment<3>(kBlack) = normals.ldlt().solve(right);
  }

  double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) override {
    const Eigen::Matrix<float, kUnknowns, 1> xf = x.cast<float>();
    const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> g = Matrix(x).inverse().cast<float>();
    const float half = static_cast<float>(half_);
    // What blur has come to since the table's, to the first order.
    const float change = static_cast<float>(x[kBlur] - std::log(options_.blur_px));
    float* row = rows_.data();
    ForEach(x, [&](const Pixel& p, float tx, float ty, float s, const TagTable::Seen& as_made) {
      TagTable::Seen seen = as_made;
      seen.white += change * seen.by_blur;
      const float px = static_cast<float>(p.x), py = static_cast<float>(p.y);
      RowOf(xf.data(), g.data(), half, px, py, tx, ty, s, seen, row);
      row[kUnknowns] =
          xf[kBlack] + xf[kWhite] * seen.white + xf[kSurround] * seen.surround - static_cast<float>(p.gray);
      row += kUnknowns + 1;
    });
    // Sums of products of all columns at once.
    sums_.noalias() = rows_ * rows_.transpose();
    normals = sums_.topLeftCorner<kUnknowns, kUnknowns>().cast<double>();
    gradient = sums_.col(kUnknowns).head<kUnknowns>().cast<double>();
    const double cost = sums_(kUnknowns, kUnknowns);
    return cost + Prior(x, normals, gradient);
  }

 private:
  template <class Work>
  void ForEach(const Unknowns& x, const Work& work) const {
    const Eigen::Matrix3f g = Matrix(x).inverse().cast<float>();
    const float half = static_cast<float>(half_), middle = 0.5f * static_cast<float>(look_.modules);
    for (const Pixel& p : pixels_) {
      const float px = static_cast<float>(p.x), py = static_cast<float>(p.y);
      const float s = g(2, 0) * px + g(2, 1) * py + g(2, 2), d = 1 / s;
      const float tx = d * (g(0, 0) * px + g(0, 1) * py + g(0, 2));
      const float ty = d * (g(1, 0) * px + g(1, 1) * py + g(1, 2));
      work(p, tx, ty, s, follow_.table.See(tx * half + middle, ty * half + middle));
    }
  }

  TagFollow& follow_;
  Eigen::Matrix<float, kUnknowns + 1, Eigen::Dynamic> rows_;
  Eigen::Matrix<float, kUnknowns + 1, kUnknowns + 1> sums_;
};

}  // namespace

std::unique_ptr<Problem> MakePlainProblem(const TagLook& look, const std::vector<Pixel>& pixels,
                                          const TagFitOptions& options) {
  return std::make_unique<PlainProblem>(look, pixels, options);
}

std::unique_ptr<Problem> MakeTableProblem(const TagLook& look, const std::vector<Pixel>& pixels,
                                          const TagFitOptions& options, TagFollow& follow,
                                          const Unknowns& start) {
  auto problem = std::make_unique<TableProblem>(look, pixels, options, follow);
  if (!problem->Prepare(start)) return nullptr;
  return problem;
}

}  // namespace tendril::tag_fit
