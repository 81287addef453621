#pragma once
// A few threads that do the parts of a short job together, thousands of times a second.

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace tendril {

class Crew {
 public:
  // The caller counts as one: Crew(1) starts no thread.
  explicit Crew(int threads);
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew();

  int threads() const { return threads_; }

  // part(0) .. part(parts - 1), each by one thread, in any order; back when all are done. Which thread does a
  // part is fixed, so a part may keep what only it touches.
  void Run(int parts, const std::function<void(int)>& part);

 private:
  void Work(int worker);

  int threads_ = 1;
  std::vector<std::thread> workers_;
  const std::function<void(int)>* part_ = nullptr;
  int parts_ = 0;
  std::atomic<unsigned> round_{0};  // grows with each job; the last of them ends the workers
  std::atomic<int> busy_{0};
  std::atomic<bool> over_{false};
};

}  // namespace tendril
