// All that a run goes on from, in numbers.
#include <algorithm>
#include <cmath>
#include <span>

#include "model/scene/scene_check.h"
#include "model/scene/stepper.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;

// Numbers of a saved state that belong together, each list behind its length.
void Append(std::vector<double>& to, std::span<const double> part) {
  to.push_back(static_cast<double>(part.size()));
  to.insert(to.end(), part.begin(), part.end());
}

// Reads such lists in turn; ok() turns false for good where one is not as long as it should be.
class Lists {
 public:
  explicit Lists(const std::vector<double>& state) : state_(state) {}
  bool ok() const { return ok_; }
  bool done() const { return ok_ && at_ == state_.size(); }
  // Of whatever length it is.
  std::vector<double> Next() {
    ok_ = ok_ && at_ < state_.size() && state_[at_] >= 0 && state_[at_] < static_cast<double>(state_.size());
    return Next(ok_ ? static_cast<std::size_t>(state_[at_]) : 0);
  }
  std::vector<double> Next(std::size_t size) {
    std::vector<double> part(size);
    ok_ = ok_ && at_ < state_.size() && state_[at_] == static_cast<double>(size) &&
          at_ + 1 + size <= state_.size();
    if (!ok_) return part;
    std::copy_n(state_.begin() + static_cast<std::ptrdiff_t>(at_) + 1, size, part.begin());
    at_ += 1 + size;
    return part;
  }

 private:
  const std::vector<double>& state_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

std::span<const double> AsSpan(const Matrix3Xd& m) { return {m.data(), static_cast<std::size_t>(m.size())}; }
void Copy(const std::vector<double>& from, Matrix3Xd& to) { std::copy(from.begin(), from.end(), to.data()); }

}  // namespace

std::vector<double> Stepper::Save() const {
  std::vector<double> state;
  const double head[] = {static_cast<double>(kicks_), options_.time_step, plan_.plain ? 1.0 : 0.0};
  Append(state, head);
  for (const Batch& batch : batches_) Append(state, LaneRods<double>(*batch.lanes).memory());
  for (std::size_t r = 0; plan_.plain && r < rods_.size(); ++r) {
    const Rod& rod = rods_[r].rod;
    Append(state, AsSpan(rod.position));
    Append(state, AsSpan(rod.velocity));
    Append(state, AsSpan(rod.spin));
    for (const Eigen::Matrix3d& q : rod.directors) Append(state, {q.data(), 9});
  }
  Append(state, bodies_.Save());
  for (const Wrench& wrench : on_bodies_) Append(state, {wrench.force.data(), 3});
  if (contacts_) Append(state, contacts_->Save());
  return state;
}

bool Stepper::Restore(const std::vector<double>& state) {
  Lists lists(state);
  const std::vector<double> head = lists.Next(3);
  if (!lists.ok() || head[1] != options_.time_step || head[2] != (plan_.plain ? 1.0 : 0.0)) return false;
  if (!(head[0] >= 0 && head[0] < 1e15 && head[0] == std::floor(head[0]))) return false;
  std::vector<std::vector<double>> memory;
  for (const Batch& batch : batches_) {
    memory.push_back(lists.Next(LaneRods<double>(*batch.lanes).memory().size()));
  }
  std::vector<Rod> plain;
  for (std::size_t r = 0; plan_.plain && r < rods_.size(); ++r) {
    Rod& rod = plain.emplace_back(rods_[r].rod);
    for (Matrix3Xd* part : {&rod.position, &rod.velocity, &rod.spin}) {
      Copy(lists.Next(static_cast<std::size_t>(part->size())), *part);
    }
    for (Eigen::Matrix3d& q : rod.directors) {
      const std::vector<double> entries = lists.Next(9);
      std::copy(entries.begin(), entries.end(), q.data());
    }
  }
  const std::vector<double> bodies = lists.Next(bodies_.Save().size());
  std::vector<std::vector<double>> forces;
  for (std::size_t b = 0; b < on_bodies_.size(); ++b) forces.push_back(lists.Next(3));
  const std::vector<double> contact = contacts_ ? lists.Next() : std::vector<double>();
  // The plain form does not keep what sticks.
  if (!lists.done() || (plan_.plain && LargestFriction(scene_) > 0)) return false;
  if ((contacts_ && !contacts_->Restore(contact)) || !bodies_.Restore(bodies)) return false;
  kicks_ = static_cast<std::int64_t>(head[0]);
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    std::copy(memory[b].begin(), memory[b].end(), batches_[b].lanes->memory().begin());
    batches_[b].driven_once = false;
  }
  for (std::size_t r = 0; r < plain.size(); ++r) rods_[r].rod = std::move(plain[r]);
  for (std::size_t b = 0; b < forces.size(); ++b)
    std::copy_n(forces[b].data(), 3, on_bodies_[b].force.data());
  return true;
}

}  // namespace tendril
