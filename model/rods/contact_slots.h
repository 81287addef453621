#pragma once
// Chosen pairs, or elements on a part of a solid, in whole eights, with the springs of what sticks. Used by
// contact_list.h.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "model/rods/contact_kernel.h"

namespace tendril {

struct ContactSlots {
  // Of each: places in a row, by which it is known (ascending by the one, then by the other), and side by
  // side.
  std::vector<int> one_place, other_place, one, other;
  int found = 0;  // the rest fills the last eight up
  std::vector<double> constants, springs;

  void Clear() {
    for (std::vector<int>* all : {&one_place, &other_place, &one, &other}) all->clear();
    constants.clear();
    found = 0;
  }
  static std::size_t PlaceOfSpring(std::size_t slot) {
    return slot / 8 * (8 * contact_kernel::kSpring) + slot % 8;
  }
  double* SpringAt(std::size_t slot) { return springs.data() + PlaceOfSpring(slot); }
  const double* SpringAt(std::size_t slot) const { return springs.data() + PlaceOfSpring(slot); }

  void Reserve(std::size_t pairs, int count) {
    for (std::vector<int>* all : {&one_place, &other_place, &one, &other}) all->reserve(pairs);
    constants.reserve(pairs * static_cast<std::size_t>(count));
    springs.reserve(pairs * contact_kernel::kSpring);
  }
  // Some of the pairs of another choice, with their constants; the last again fills the last eight up.
  void TakePairs(const ContactSlots& from, std::span<const int> slots, int count) {
    const std::size_t size = (slots.size() + 7) / 8 * 8, rows = static_cast<std::size_t>(count);
    found = static_cast<int>(slots.size());
    for (std::vector<int>* all : {&one_place, &other_place, &one, &other}) all->resize(size);
    constants.resize(size * rows);
    for (std::size_t p = 0; p < size; ++p) {
      const auto slot = static_cast<std::size_t>(slots[std::min(p, slots.size() - 1)]);
      one_place[p] = from.one_place[slot], other_place[p] = from.other_place[slot];
      one[p] = from.one[slot], other[p] = from.other[slot];
      const double* const old = from.constants.data() + slot / 8 * (8 * rows) + slot % 8;
      double* const to = constants.data() + p / 8 * (8 * rows) + p % 8;
      for (std::size_t row = 0; row < rows; ++row) to[8 * row] = old[8 * row];
    }
  }

  // Springs of another choice of the same elements, where they are here too; else none.
  void TakeSprings(const ContactSlots& from) {
    const std::size_t size = one_place.size();
    springs.assign((size + 7) / 8 * (8 * contact_kernel::kSpring), 0.0);
    std::size_t old = 0;
    const auto count = static_cast<std::size_t>(from.found);
    for (std::size_t slot = 0; slot < static_cast<std::size_t>(found); ++slot) {
      const auto before = [&](std::size_t k) {
        return from.one_place[k] != one_place[slot] ? from.one_place[k] < one_place[slot]
                                                    : from.other_place[k] < other_place[slot];
      };
      while (old < count && before(old)) ++old;
      if (old == count) break;
      if (from.one_place[old] != one_place[slot] || from.other_place[old] != other_place[slot]) continue;
      for (int row = 0; row < contact_kernel::kSpring; ++row)
        SpringAt(slot)[8 * row] = from.SpringAt(old)[8 * row];
    }
  }

  // Springs that hold something: place, place, and the spring's rows, one after the other.
  void SaveSprings(std::vector<double>& to) const {
    const std::size_t at = to.size();
    to.push_back(0);
    for (std::size_t slot = 0; !springs.empty() && slot < static_cast<std::size_t>(found); ++slot) {
      const double* const spring = SpringAt(slot);
      if (spring[0] == 0 && spring[8] == 0 && spring[16] == 0 && spring[24] == 0) continue;
      to[at] += 1;
      to.push_back(one_place[slot]);
      to.push_back(other_place[slot]);
      for (int row = 0; row < contact_kernel::kSpring; ++row) to.push_back(spring[8 * row]);
    }
  }
  //   returns  how many numbers it took
  std::size_t RestoreSprings(const double* from) {
    Clear();
    found = static_cast<int>(from[0]);
    const auto size = static_cast<std::size_t>(found);
    springs.assign((size + 7) / 8 * (8 * contact_kernel::kSpring), 0.0);
    std::size_t at = 1;
    for (std::size_t slot = 0; slot < size; ++slot) {
      one_place.push_back(static_cast<int>(from[at++]));
      other_place.push_back(static_cast<int>(from[at++]));
      for (int row = 0; row < contact_kernel::kSpring; ++row) SpringAt(slot)[8 * row] = from[at++];
    }
    return at;
  }
};

}  // namespace tendril
