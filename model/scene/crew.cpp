#include "model/scene/crew.h"

namespace tendril {
namespace {

// A job lasts some ten microseconds: whoever waits for the next looks for as long before giving up the core.
constexpr int kLooks = 2000;

template <class Done>
void WaitFor(const Done& done) {
  for (int look = 0; !done(); ++look) {
    if (look >= kLooks) std::this_thread::yield();
  }
}

}  // namespace

Crew::Crew(int threads) : threads_(threads > 1 ? threads : 1) {
  for (int worker = 1; worker < threads; ++worker) workers_.emplace_back([this, worker] { Work(worker); });
}

Crew::~Crew() {
  over_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  for (std::thread& worker : workers_) worker.join();
}

void Crew::Run(int parts, const std::function<void(int)>& part) {
  if (workers_.empty() || parts <= 1) {
    for (int p = 0; p < parts; ++p) part(p);
    return;
  }
  part_ = &part;
  parts_ = parts;
  busy_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  for (int p = 0; p < parts; p += threads()) part(p);
  WaitFor([this] { return busy_.load(std::memory_order_acquire) == 0; });
}

void Crew::Work(int worker) {
  for (unsigned seen = 0;;) {
    WaitFor([&] { return round_.load(std::memory_order_acquire) != seen; });
    ++seen;
    if (over_.load(std::memory_order_relaxed)) return;
    for (int p = worker; p < parts_; p += threads()) (*part_)(p);
    busy_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace tendril
