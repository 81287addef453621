#pragma once
// Quantiles of Student's t, for intervals from few clusters.

namespace tendril {

// P(T <= t) for T with `dof` degrees of freedom (> 0, need not be whole). Absolute error below 1e-13.
double StudentTCdf(double t, double dof);

// The t with P(T <= t) = probability, probability in (0, 1). Relative error below 1e-10.
double StudentTQuantile(double probability, double dof);

}  // namespace tendril
