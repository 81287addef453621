#include "analysis/link/link_tree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "analysis/link/link_kernel.h"
#include "analysis/link/solid_angle.h"
#include "model/geometry/segment_distance.h"

namespace tendril {
namespace {

constexpr uint32_t kLeaf = 32;  // segments; measured (bench/link, rows Tree)

Eigen::Vector3d Point(const Strand& s, size_t i) { return {s.x[i], s.y[i], s.z[i]}; }

// A node of the other curve and how often the triangles' solid angle seen from it counts.
struct Seen {
  uint32_t from;
  int times;
};

// Halves of halves of a curve, down to single segments. Stretch k's nodes lie in the capsule about its chord.
class Tree {
 public:
  struct Stretch {
    uint32_t first, last;  // nodes
    uint32_t left = 0;     // its halves: left and left + 1; 0: a single segment
    double radius = 0;     // of the capsule
    std::vector<Seen> seen;
  };

  explicit Tree(const Strand& strand) : strand_(strand) {
    stretches_.reserve(2 * strand.nodes());
    stretches_.push_back({0, static_cast<uint32_t>(strand.nodes() - 1), 0, 0, {}});
    // Children stand behind their parents, so going back through the list visits them first.
    for (uint32_t k = 0; k < stretches_.size(); ++k) {
      const uint32_t first = stretches_[k].first, last = stretches_[k].last;
      if (last - first < 2) continue;
      const uint32_t middle = first + (last - first) / 2;
      stretches_[k].left = static_cast<uint32_t>(stretches_.size());
      stretches_.push_back({first, middle, 0, 0, {}});
      stretches_.push_back({middle, last, 0, 0, {}});
    }
    for (size_t k = stretches_.size(); k-- > 0;) {
      Stretch& s = stretches_[k];
      if (s.left == 0) continue;
      // The halves' chords are within the middle node's distance of the whole one.
      const Eigen::Vector3d middle = Point(strand, stretches_[s.left].last);
      const double off =
          ClosestOfSegments(Point(strand, s.first), Point(strand, s.last), middle, middle).apart.norm();
      s.radius = off + std::max(stretches_[s.left].radius, stretches_[s.left + 1].radius);
    }
  }

  const Strand& strand() const { return strand_; }
  Stretch& operator[](uint32_t k) { return stretches_[k]; }
  static uint32_t Segments(const Stretch& s) { return s.last - s.first; }

  // The triangles' part of the sum: each stretch's, seen from where it was asked for or any stretch around
  // it.
  void AddTriangles(const Strand& other, TreeSum& sum) {
    std::vector<Seen> none;
    AddTrianglesOf(0, none, other, sum);
  }

 private:
  // Sorted by node, each node once, none zero times.
  static std::vector<Seen> Merged(std::vector<Seen> a, const std::vector<Seen>& b) {
    a.insert(a.end(), b.begin(), b.end());
    std::sort(a.begin(), a.end(), [](const Seen& x, const Seen& y) { return x.from < y.from; });
    std::vector<Seen> merged;
    for (const Seen& seen : a) {
      if (!merged.empty() && merged.back().from == seen.from) {
        merged.back().times += seen.times;
        if (merged.back().times == 0) merged.pop_back();
      } else {
        merged.push_back(seen);
      }
    }
    return merged;
  }

  void AddTrianglesOf(uint32_t k, const std::vector<Seen>& inherited, const Strand& other, TreeSum& sum) {
    Stretch& s = stretches_[k];
    if (s.left == 0) return;
    const std::vector<Seen>* seen = &inherited;
    std::vector<Seen> merged;
    if (!s.seen.empty()) {
      merged = Merged(std::move(s.seen), inherited);
      seen = &merged;
    }
    const Vec3<double> p = strand_.node(s.first), q = strand_.node(stretches_[s.left].last),
                       r = strand_.node(s.last);
    for (const Seen& from : *seen) {
      sum.angle += from.times * TriangleAngle(p, q, r, other.node(from.from));
      ++sum.triangles;
    }
    AddTrianglesOf(s.left, *seen, other, sum);
    AddTrianglesOf(s.left + 1, *seen, other, sum);
  }

  // The solid angle of a triangle seen from a point outside of it, in the sign by which the Gauss integral of
  // its border p q r with a path is the angle at the path's end minus that at its start.
  // Source: Van Oosterom and Strackee 1983.
  static double TriangleAngle(const Vec3<double>& p, const Vec3<double>& q, const Vec3<double>& r,
                              const Vec3<double>& from) {
    const Vec3<double> a = p - from, b = q - from, c = r - from;
    const double na = Norm(a), nb = Norm(b), nc = Norm(c);
    const double volume = Dot(a, Cross(q - p, r - p));
    const double d = na * nb * nc + Dot(a, b) * nc + Dot(b, c) * na + Dot(c, a) * nb;
    return kSign * 2 * std::atan2(volume, d);
  }
  static constexpr double kSign = 1;

  const Strand& strand_;
  std::vector<Stretch> stretches_;
};

class Summation {
 public:
  // closed: own sums only.
  Summation(Tree& a, Tree& b, bool own, bool closed) : a_(a), b_(b), own_(own), closed_(closed) {}

  TreeSum Run() {
    own_ ? Within(0) : Between(0, 0);
    a_.AddTriangles(b_.strand(), sum_);
    if (!own_) b_.AddTriangles(a_.strand(), sum_);
    return std::move(sum_);
  }

 private:
  static NodeArrays Part(const Strand& s, const SegmentRange& range) {
    return {s.x.data() + range.first, s.y.data() + range.first, s.z.data() + range.first,
            range.end - range.first + 1};
  }

  void Within(uint32_t k) {
    const Tree::Stretch& s = a_[k];
    if (Tree::Segments(s) <= kLeaf) {
      if (Tree::Segments(s) < 3) return;
      const SegmentRange range{s.first, s.last};
      const AngleSum block = SumOwnSegmentAngles(Part(a_.strand(), range));
      sum_.pairs += Tree::Segments(s) * Tree::Segments(s) / 2;
      if (block.suspicious)
        sum_.doubtful.push_back({range, range});
      else
        sum_.angle += block.angle;
      return;
    }
    const uint32_t left = s.left;
    Within(left);
    Within(left + 1);
    Between(left, left + 1);
  }

  void Between(uint32_t i, uint32_t j) {
    Tree::Stretch& a = a_[i];
    Tree::Stretch& b = b_[j];
    const uint32_t a_size = Tree::Segments(a), b_size = Tree::Segments(b);
    if (a_size > 1 || b_size > 1) {
      const Eigen::Vector3d a0 = Point(a_.strand(), a.first), a1 = Point(a_.strand(), a.last);
      const Eigen::Vector3d b0 = Point(b_.strand(), b.first), b1 = Point(b_.strand(), b.last);
      const double apart = ClosestOfSegments(a0, a1, b0, b1).apart.norm();
      // The share is far above what rounding does to either side, and below what matters.
      const double room = 1e-6 * (apart + (b0 - a0).norm());
      if (apart > a.radius + b.radius + room) {
        sum_.angle += SegmentSegmentAngle(a_.strand().node(a.first), a_.strand().node(a.last),
                                          b_.strand().node(b.first), b_.strand().node(b.last))
                          .angle;
        ++sum_.pairs;
        if (a_size > 1) {
          a.seen.push_back({b.last, 1});
          a.seen.push_back({b.first, -1});
        }
        if (b_size > 1) {
          // By now the other stretch is its chord, with the same ends.
          b.seen.push_back({a.last, 1});
          b.seen.push_back({a.first, -1});
        }
        return;
      }
    }
    if (a_size <= kLeaf && b_size <= kLeaf) return Near({a.first, a.last}, {b.first, b.last});
    const bool split_a = b_size <= kLeaf || (a_size > kLeaf && a_size >= b_size);
    if (split_a) {
      const uint32_t left = a.left;
      Between(left, j);
      Between(left + 1, j);
    } else {
      const uint32_t left = b.left;
      Between(i, left);
      Between(i, left + 1);
    }
  }

  // Pair by pair; of one curve without neighbours, which share a node.
  void Near(const SegmentRange& a, const SegmentRange& b) {
    if (a.first == a.end || b.first == b.end) return;
    if (own_ && a.end == b.first) {
      Near({a.first, a.end - 1}, b);
      return Near({a.end - 1, a.end}, {b.first + 1, b.end});
    }
    if (closed_ && a.first == 0 && b.end + 1 == b_.strand().nodes()) {
      Near({1, a.end}, b);
      return Near({0, 1}, {b.first, b.end - 1});
    }
    const AngleSum block = SumSegmentAngles(Part(a_.strand(), a), Part(b_.strand(), b));
    sum_.pairs += (a.end - a.first) * (b.end - b.first);
    if (block.suspicious)
      sum_.doubtful.push_back({a, b});
    else
      sum_.angle += block.angle;
  }

  Tree& a_;
  Tree& b_;
  bool own_;
  bool closed_;
  TreeSum sum_;
};

}  // namespace

TreeSum SumByTree(const Strand& a, const Strand& b) {
  Tree first(a), second(b);
  return Summation(first, second, false, false).Run();
}

TreeSum SumOwnByTree(const Strand& s, bool closed) {
  Tree tree(s);
  return Summation(tree, tree, true, closed).Run();
}

}  // namespace tendril
