#include "model/fold/fold.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

#include "model/check.h"

namespace tendril {
namespace {

std::string Number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

bool IsRightAngle(double closed_angle) { return closed_angle >= std::numbers::pi / 2; }

// An unevaluated sum of two doubles, about 32 digits. Needed for one difference: what the closed creases
// leave over of the shortening for the open ones. Where stiffnesses differ by 1e9 that may be the last
// digits of either, and the open creases' angles are all in it.
struct Double2 {
  double high = 0;
  double low = 0;

  void Add(double x) {
    const double sum = high + x;
    const double part = sum - high;
    low += (high - (sum - part)) + (x - part);
    high = sum;
  }
};

Double2 Times(const Double2& a, double b) {
  const double product = a.high * b;
  return {product, std::fma(a.high, b, -product) + a.low * b};
}

// a - b. The high parts' difference is exact where they are close, which is where it matters.
double Minus(const Double2& a, const Double2& b) {
  Double2 difference = a;
  difference.Add(-b.high);
  difference.low -= b.low;
  return difference.high + difference.low;
}

// 1 - cos(closed_angle) to 19 digits; exactly 1 for a right angle, which pi / 2 as a double stands for.
Double2 ClosedShare(double closed_angle) {
  if (IsRightAngle(closed_angle)) return {1, 0};
  const long double s = std::sin(0.5L * closed_angle);
  const long double share = 2 * s * s;
  const double high = static_cast<double>(share);
  return {high, static_cast<double>(share - high)};
}

}  // namespace

double LargestPull(double closed_angle) { return ClosedShare(closed_angle).high; }

// In u = k^2 the shortening g(u) = sum 4 d sin^2(phi / 2) rises and is concave: each term's slope
// d x sin(k x) / k falls with k, and drops to 0 where the crease closes. Newton's method that starts left of
// the root therefore never passes it, kinks included, and needs no bracket.
Result<Fold> SolveFold(const TentacleLayout& layout, double base_width, double closed_angle, double pull) {
  const Eigen::Index creases = layout.half_spacing.size();
  TENDRIL_CHECK(creases > 0 && layout.stiffness.size() == creases);
  TENDRIL_CHECK(base_width > 0 && closed_angle > 0);
  if (!(pull >= 0) || !std::isfinite(pull)) {
    return Error{ErrorKind::kBadInput, "pull = " + Number(pull) + ": expected a fraction, 0 to " +
                                           Number(LargestPull(closed_angle))};
  }
  if (pull > LargestPull(closed_angle)) {
    return Error{ErrorKind::kUnreachable, "pull = " + Number(pull) +
                                              " is beyond reach: every crease is closed at pull " +
                                              Number(LargestPull(closed_angle)) + ", the largest possible"};
  }
  const double closed_at = std::min(closed_angle, std::numbers::pi / 2);

  const Eigen::VectorXd& half_spacing = layout.half_spacing;
  Fold fold;
  fold.angle.resize(creases);  // holds x_i = d_i / W_i until k is known
  Double2 flat_length;
  double curvature = 0;  // dg/du at u = 0: sum d x^2
  double smallest = HUGE_VAL;
  double largest = 0;
  for (Eigen::Index i = 0; i < creases; ++i) {
    const double x = half_spacing[i] / (base_width * layout.stiffness[i]);
    fold.angle[i] = x;
    flat_length.Add(2 * half_spacing[i]);
    curvature += half_spacing[i] * x * x;
    smallest = std::min(smallest, x);
    largest = std::max(largest, x);
  }

  const Double2 closed_share = ClosedShare(closed_angle);
  const Double2 wanted = Times(flat_length, pull);
  const double all_closed = closed_at / smallest;
  double k = std::sqrt(wanted.high) / std::sqrt(curvature);  // the quotient itself may underflow
  if (pull == closed_share.high) {
    k = all_closed;
  } else if (k * largest > 1e-9) {  // below, the start is the answer to 1e-18
    // 3 to 8 for the paper's tentacle, 28 at most over 20,000 random designs.
    for (int iteration = 0; iteration < 500; ++iteration) {
      Double2 closed_length;
      double open = 0;
      double slope = 0;  // dg/du
      double next_closing = 0;
      for (Eigen::Index i = 0; i < creases; ++i) {
        const double x = fold.angle[i];
        if (k * x >= closed_at) {
          closed_length.Add(2 * half_spacing[i]);
          continue;
        }
        const double sine = std::sin(0.5 * k * x);
        const double cosine = std::cos(0.5 * k * x);
        open += 4 * half_spacing[i] * sine * sine;
        slope += 2 * half_spacing[i] * x * sine * cosine;
        next_closing = std::max(next_closing, x);
      }
      if (slope <= 0) break;  // all closed: rounding took the last step there
      slope /= k;
      const Double2 closed = {
          closed_share.high * closed_length.high,
          std::fma(closed_share.high, closed_length.high, -closed_share.high * closed_length.high) +
              closed_share.high * closed_length.low + closed_share.low * closed_length.high};
      const double step = (Minus(wanted, closed) - open) / slope;
      const double u = k * k;
      const double next = std::sqrt(std::max(0.0, u + step));
      const bool kink_ahead = next * next_closing >= closed_at;
      // Quadratic convergence: after a step of 1e-9 u the rest is below rounding, if no kink was passed.
      const bool done = std::abs(step) <= (kink_ahead ? 2e-16 : 1e-9) * u;
      k = next;
      if (done) break;
    }
    k = std::min(k, all_closed);
  }

  fold.scale = k;
  for (Eigen::Index i = 0; i < creases; ++i) {
    const bool closed = pull == closed_share.high || k * fold.angle[i] >= closed_at;
    fold.angle[i] = closed ? closed_at : k * fold.angle[i];
    if (closed) fold.closed.push_back(static_cast<int>(i));
    const bool zero_length = closed && IsRightAngle(closed_angle);
    fold.tendon_length += zero_length ? 0.0 : 2 * half_spacing[i] * std::cos(fold.angle[i]);
  }
  return fold;
}

Result<Fold> SolveFold(const TentacleDesign& design, double pull) {
  const Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  return SolveFold(layout.value(), design.base_width, design.closed_angle, pull);
}

}  // namespace tendril
