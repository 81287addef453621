#pragma once
// How large a square tag each facet of a flat sheet can hold: beside the tendon's hole, or over it.
//
// SI units; points are (y, z) of the sheet's frame. Tags stand upright: their sides run along y and z.

#include <Eigen/Core>
#include <vector>

#include "model/fold/design.h"

namespace tendril {

// Points p with inward . p >= offset; inward is a unit vector.
struct HalfPlane {
  Eigen::Vector2d inward;
  double offset;
};

struct FacetRoom {
  double length = 0;       // along the centerline, m
  double width = 0;        // across, at the hole, m
  double before_hole = 0;  // from the hole's centre to the crease or end toward the base, m
  double beyond_hole = 0;  // to that toward the tip, m
  double largest_beside =
      0;                    // side of the largest square clear of the hole and the facet's edges, m; 0: none
  double largest_over = 0;  // of the largest centred on the hole, clear of the edges, m; 0: none
  Eigen::Vector2d hole;     // m
  std::vector<Eigen::Vector2d> corners;  // m

  // One way to pass the hole: the facet's edges and one line that the square keeps beyond.
  struct Way {
    std::vector<HalfPlane> within;
    double largest = 0;  // side of the largest square, m
  };
  std::vector<Way> ways;  // beyond the hole, before it, on either side of it
};

// One per facet. clearance: kept free around hole, creases and edges, m.
std::vector<FacetRoom> RoomsOf(const TentacleDesign& design, const TentacleLayout& layout, double clearance);

// Centre of a square of this side beside the hole, in the middle of where it may lie; the caller has made
// sure that side <= largest_beside.
Eigen::Vector2d PlaceBesideHole(const FacetRoom& room, double side);

}  // namespace tendril
