#pragma once
// How a long call tells its caller how far it is, and asks whether to go on. Libraries print nothing.

#include <functional>

namespace tendril {

// Called with the share of the work that is done, 0 .. 1; returns false to ask the call to stop (it then
// returns kStopped). May be called from any thread the call was told to use, never from two at once.
using Progress = std::function<bool(double done)>;

// Part of a longer work: `done` of it runs from `from` to `to` of the whole.
inline Progress PartOf(const Progress& whole, double from, double to) {
  return [whole, from, to](double done) { return !whole || whole(from + (to - from) * done); };
}

}  // namespace tendril
