#pragma once
// A bounded queue of pictures between the thread that takes them and the one that writes them.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "capture/record/frame_source.h"

namespace tendril {

struct QueuedFrame {
  SourceFrame frame;
  std::int64_t dropped_before = 0;
};

class FrameQueue {
 public:
  explicit FrameQueue(std::size_t capacity) : capacity_(capacity) {}

  // Waits for room; false once the queue is closed.
  bool Push(QueuedFrame frame) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || frames_.size() < capacity_; });
    if (closed_) return false;
    frames_.push_back(std::move(frame));
    changed_.notify_all();
    return true;
  }

  // False, and `frame` is as it was, if there is no room now.
  bool TryPush(QueuedFrame& frame) {
    const std::lock_guard lock(mutex_);
    if (closed_ || frames_.size() >= capacity_) return false;
    frames_.push_back(std::move(frame));
    changed_.notify_all();
    return true;
  }

  // The next picture; none once the queue is closed and empty.
  std::optional<QueuedFrame> Pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !frames_.empty(); });
    if (frames_.empty()) return std::nullopt;
    QueuedFrame frame = std::move(frames_.front());
    frames_.pop_front();
    changed_.notify_all();
    return frame;
  }

  // Nothing more comes in; what is in it can still be taken out.
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<QueuedFrame> frames_;
  bool closed_ = false;
};

}  // namespace tendril
