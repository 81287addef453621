#pragma once
// How far apart is a response on the way up and on the way down, at equal drive? The width of its loop, and
// how sure that is where rows that follow each other are not independent.
//
// Any units; `drive` is what is commanded, `response` what it brings about, row by row in the order of time.

#include <Eigen/Core>
#include <vector>

namespace tendril {

// Rows in which the drive goes one way. Those in which it is held where it turned belong to the way there.
struct DriveStroke {
  Eigen::Index first = 0, last = 0;  // rows, both included
  bool rises = false;
};

struct HysteresisOptions {
  double reversal = 0.05;     // of the drive's range: what turns back by less is part of the stroke
  double largest_gap = 0.25;  // of the range: between rows further apart in drive nothing is interpolated
  int levels = 21;            // of drive, evenly over its range, at which strokes are compared; two or more
};

// A stroke and the next, which goes the other way.
struct HysteresisCycle {
  Eigen::Index first = 0, last = 0;  // rows
  int levels = 0;                    // that both strokes reached
  double width = 0;                  // mean over those levels of rising less falling response
  double sigma = 0;  // of the width from the rows' own sigma, were a stroke's rows all wrong alike
  // At each level: the responses, and the sigma of their difference likewise; NaN: not reached by both.
  Eigen::VectorXd rising, falling, difference_sigma;
};

struct Hysteresis {
  Eigen::VectorXd level;  // of drive                                           (levels)
  std::vector<DriveStroke> strokes;
  std::vector<HysteresisCycle> cycles;  // those with a level to compare; no stroke is in two
  double width = 0;                     // mean of the cycles by their levels; NaN: no cycle
  double standard_error = 0;  // of it from the cycles' scatter, cycles as blocks; NaN: fewer than two
  double half_95 = 0;         // half the 95 % interval by Student's t; NaN: fewer than two cycles
  double sigma = 0;           // of it from the rows' own sigma alone; NaN: none stated
};

// Strokes that turn back by more than `reversal` (in the drive's units) each. Rows with a drive of NaN are
// passed over; those up to the drive's first move belong to no stroke.
std::vector<DriveStroke> DriveStrokes(const Eigen::VectorXd& drive, double reversal);

// Rows with a drive or a response of NaN are left out. Within a stroke the response at a level is
// interpolated linearly in drive, rows of equal drive count as their mean. Strokes are paired from the first
// or from the second on, whichever compares more levels (the response has no say in it).
//   sigma  of each response; NaN or no entries: not known                                       (rows)
// The standard error is that of a ratio: sum_c n_c^2 (w_c - w)^2 C / (C - 1) / (sum_c n_c)^2, n_c levels in
// cycle c.
//   source  Cochran, Sampling Techniques, 3rd ed., 2.11 and 9A.2 (cluster totals over cluster sizes)
Hysteresis MeasureHysteresis(const Eigen::VectorXd& drive, const Eigen::VectorXd& response,
                             const Eigen::VectorXd& sigma = {}, const HysteresisOptions& options = {});

// How much rows scatter about what changes smoothly from row to row: a robust standard deviation from third
// differences. Errors that last over several rows do not show. NaN with fewer than five rows; rows of NaN are
// left out.
double RowScatter(const Eigen::VectorXd& values);

}  // namespace tendril
