#pragma once
// Exact sums of segment-pair solid angles over long polylines, in much less than all pairs.
//
// A stretch of one curve may be drawn straight, to its chord, if the other curve's stretch does not pass
// through the area swept. The swept area is cut into triangles; what changes is then the solid angle of those
// triangles seen from the other stretch's last node minus that seen from its first, to the digit (Stokes: the
// Gauss integral of a closed loop along a path is the change of the loop's solid angle). Stretches in
// capsules that do not meet qualify both ways. Seen from nodes where stretches join, the changes cancel, so
// curves far apart cost one pair of chords and two solid angles per node; only where curves come close are
// segments taken pair by pair.

#include <cstddef>
#include <vector>

#include "analysis/link/closure.h"

namespace tendril {

struct SegmentRange {
  size_t first = 0, end = 0;  // segment i runs from node i to node i + 1
};

struct TreeSum {
  double angle = 0;  // of all pairs but those in `doubtful`, rad
  // Blocks in which a pair touches or crosses in a plane, or nearly (link_kernel.h): to be summed in the
  // scalar form.
  struct Block {
    SegmentRange a, b;
  };
  std::vector<Block> doubtful;
  size_t pairs = 0;      // evaluated, of segments or chords
  size_t triangles = 0;  // evaluated
};

// All segments of a against all of b.   Preconditions: two nodes or more each, finite
TreeSum SumByTree(const Strand& a, const Strand& b);

// All of one curve against its own non-neighbours, each pair once. `closed`: its last node is its first.
// Doubtful blocks may hold neighbours, and pairs twice over the diagonal (a = b): take i < j.
TreeSum SumOwnByTree(const Strand& s, bool closed);

}  // namespace tendril
