#include "capture/track/tag_fit_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/track/tag_fit_kernel.h"
#include "model/machine.h"

namespace tendril::tag_fit {

std::optional<Eigen::Matrix<double, 8, 1>> HomographyTo(const Corners& corners) {
  // With w what the homography divides a corner by, w0 p0 + w2 p2 = w1 p1 + w3 p3 and w0 + w2 = 2 = w1 + w3.
  const Eigen::Vector2d p0 = corners.col(0), p1 = corners.col(1), p2 = corners.col(2), p3 = corners.col(3);
  const Eigen::Vector2d one = p0 - p2, other = p1 - p3, right = 2 * (p3 - p2);
  const double area = one.y() * other.x() - one.x() * other.y();
  if (!(std::abs(area) > 1e-9 * (one.squaredNorm() + other.squaredNorm()))) return std::nullopt;
  const double w0 = (right.y() * other.x() - right.x() * other.y()) / area;
  const double w1 = (one.x() * right.y() - one.y() * right.x()) / area;
  Eigen::Matrix<double, 8, 1> h;
  h[6] = 0.5 * (w1 - w0);
  h[7] = 0.5 * (w0 + w1) - 1;
  const Eigen::Vector2d middle = 0.5 * (w0 * p0 + (2 - w0) * p2), by_x = 0.5 * (w1 * p1 - w0 * p0);
  const Eigen::Vector2d by_y = 0.5 * (w0 * p0 + w1 * p1) - middle;
  h.head<6>() << by_x.x(), by_y.x(), middle.x(), by_x.y(), by_y.y(), middle.y();
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

const Kernels& KernelsOfThisMachine() {
#ifdef TENDRIL_FIT_X86
  static const Kernels kernels = MachineDoubles() == 8   ? Avx512Kernels()
                                 : MachineDoubles() == 4 ? Avx2Kernels()
                                                         : BaseKernels();
#else
  static const Kernels kernels = BaseKernels();
#endif
  return kernels;
}

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

  void StartContrast(Unknowns& x) override {
    const Eigen::Matrix3d g = Matrix(x).inverse();
    const Eigen::Matrix2d blur = BlurOf(x, g, half_, std::exp(x[kBlur]));
    if (!IsFine(blur)) return;
    const TagSeer seer(look_, blur);
    Eigen::Matrix3d normals = Eigen::Vector3d(0, 0, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int i = 0; i < pixels_.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double px = pixels_.x[at], py = pixels_.y[at], gray = pixels_.gray[at];
      const double d = half_ / (g(2, 0) * px + g(2, 1) * py + g(2, 2));
      const SeenTag seen = seer.See(d * (g(0, 0) * px + g(0, 1) * py + g(0, 2)) + 0.5 * look_.modules,
                                    d * (g(1, 0) * px + g(1, 1) * py + g(1, 2)) + 0.5 * look_.modules);
      const Eigen::Vector3d j(1, seen.white, seen.surround);
      normals += j * j.transpose();
      right += gray * j;
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
    for (int i = 0; i < pixels_.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double px = pixels_.x[at], py = pixels_.y[at], gray = pixels_.gray[at];
      const double s = g[6] * px + g[7] * py + g[8];
      const double tx = (g[0] * px + g[1] * py + g[2]) / s, ty = (g[3] * px + g[4] * py + g[5]) / s;
      const SeenTag seen = seer.See(tx * half_ + 0.5 * look_.modules, ty * half_ + 0.5 * look_.modules);
      const double residual = x[kBlack] + x[kWhite] * seen.white + x[kSurround] * seen.surround - gray;
      cost += residual * residual;
      RowOf(x.data(), g, half_, px, py, tx, ty, s, seen, j.data());
      normals.selfadjointView<Eigen::Lower>().rankUpdate(j);
      gradient += residual * j;
    }
    normals.triangularView<Eigen::StrictlyUpper>() = normals.transpose();
    return cost;
  }
};

constexpr double kBlurChange = 0.12;

// By a TagTable in single precision, many pixels at once.
class TableProblem : public Problem {
 public:
  TableProblem(const TagLook& look, const Pixels& pixels, const TagFitOptions& options, TagFollow& follow)
      : Problem(look, pixels, options), follow_(follow) {}

  // Makes the table anew where it must; false: no table serves.
  bool Prepare(const Unknowns& x) {
    const Eigen::Matrix2d blur = BlurOf(x, Matrix(x).inverse(), half_, options_.blur_px);
    if (!IsFine(blur) || !TagTable::CanServe(blur)) return false;
    // A little more or less blur is the fit's to tell, and the table knows its slope.
    const double ratio = follow_.blur_px / options_.blur_px;
    if (!(std::abs(ratio - 1) < kBlurChange) || !follow_.table.Serves(ratio * ratio * blur)) {
      follow_.table.Make(look_, blur);
      follow_.blur_px = options_.blur_px;
    }
    if (follow_.white - follow_.black > 0) ComeNear();
    return true;
  }

  void StartContrast(Unknowns& x) override {
    if (follow_.white - follow_.black > 0) {
      x.segment<3>(kBlack) << follow_.black, follow_.white - follow_.black, follow_.surround - follow_.black;
      return;
    }
    // Without any brightness the residual is what the pixels have.
    Unknowns dark = x;
    dark.segment<3>(kBlack).setZero();
    Normals normals;
    Unknowns gradient;
    Sum(dark, normals, gradient);
    Eigen::Matrix3d seen = normals.block<3, 3>(kBlack, kBlack);
    seen(2, 2) += 1e-6;
    x.segment<3>(kBlack) = seen.ldlt().solve(-gradient.segment<3>(kBlack));
  }

  double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) override {
    const double cost = Sum(x, normals, gradient);
    return cost + Prior(x, normals, gradient);
  }

 private:
  double Sum(const Unknowns& x, Normals& normals, Unknowns& gradient) const {
    const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> g = Matrix(x).inverse().cast<float>();
    Evaluate e{.table = follow_.table.View(),
               .pixels = pixels_.count,
               .x = pixels_.x.data(),
               .y = pixels_.y.data(),
               .gray = pixels_.gray.data(),
               .g = {},
               .black = static_cast<float>(x[kBlack]),
               .white = static_cast<float>(x[kWhite]),
               .surround = static_cast<float>(x[kSurround]),
               .blur_change = static_cast<float>(x[kBlur] - std::log(follow_.blur_px)),
               .half = static_cast<float>(half_),
               .middle = 0.5f * static_cast<float>(look_.modules),
               .sums = {}};
    std::copy_n(g.data(), 9, e.g);
    KernelsOfThisMachine().evaluate(e);
    for (int r = 0; r < kUnknowns; ++r) {
      for (int c = 0; c <= r; ++c) normals(r, c) = normals(c, r) = e.sums[r][c];
      gradient[r] = e.sums[kUnknowns][r];
    }
    return e.sums[kUnknowns][kUnknowns];
  }

  TagFollow& follow_;
};

}  // namespace

std::unique_ptr<Problem> MakePlainProblem(const TagLook& look, const Pixels& pixels,
                                          const TagFitOptions& options) {
  return std::make_unique<PlainProblem>(look, pixels, options);
}

std::unique_ptr<Problem> MakeTableProblem(const TagLook& look, const Pixels& pixels,
                                          const TagFitOptions& options, TagFollow& follow,
                                          const Unknowns& start) {
  auto problem = std::make_unique<TableProblem>(look, pixels, options, follow);
  if (!problem->Prepare(start)) return nullptr;
  return problem;
}

}  // namespace tendril::tag_fit
