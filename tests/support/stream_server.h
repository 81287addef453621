#pragma once
// Cameras for tests: a film of drawn tags, and a server on a free port of this machine that sends a file's
// bytes to whoever connects, slowly enough to look live.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "capture/record/video_file.h"
#include "tests/support/program.h"
#include "tests/support/render_tag.h"

namespace tendril::testing_support {

// `frames` pictures of 240 x 120 px, 1 / fps apart, of tags that move slowly.
inline std::string FilmOfTags(const std::string& file, const std::vector<int>& ids, int frames, double fps) {
  std::mt19937 random(3);
  VideoWriter writer = VideoWriter::Open(file, 240, 120).value();
  for (int f = 0; f < frames; ++f) {
    Picture picture(240, 120, 80);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      DrawTag(picture, PatternOf("tag36h11", ids[i]).value(), 8,
              TiltedCorners({45 + 70.0 * static_cast<double>(i) + 0.2 * f, 60}, 24, 0.3, 1, 0));
    }
    Blur(picture, 0.8);
    AddNoise(picture, 2, random);
    auto bytes = picture.Bytes();
    EXPECT_TRUE(writer.Write(cv::Mat(120, 240, CV_8U, bytes.data()), f / fps).ok());
  }
  EXPECT_TRUE(writer.Close().ok());
  return file;
}

// Sends the file's bytes in `pieces`, a pause after each, to one caller after the other, then hangs up.
class StreamServer {
 public:
  StreamServer(const std::string& file, int pieces, int pause_ms)
      : bytes_(ReadText(file)), pieces_(pieces), pause_ms_(pause_ms) {
    socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(socket_, 4), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~StreamServer() {
    stop_ = true;
    thread_.join();
    close(socket_);
  }
  StreamServer(const StreamServer&) = delete;
  StreamServer& operator=(const StreamServer&) = delete;

  std::string url() const { return "tcp://127.0.0.1:" + std::to_string(port_); }
  int callers() const { return callers_; }

 private:
  void Serve() {
    while (!stop_) {
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      if (poll(&waiting, 1, 20) <= 0) continue;
      const int caller = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
      ++callers_;
      const std::size_t piece = bytes_.size() / static_cast<std::size_t>(pieces_) + 1;
      for (std::size_t at = 0; at < bytes_.size() && !stop_; at += piece) {
        if (send(caller, bytes_.data() + at, std::min(piece, bytes_.size() - at), MSG_NOSIGNAL) < 0) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms_));
      }
      close(caller);
    }
  }

  std::string bytes_;
  int pieces_, pause_ms_, port_ = 0, socket_ = -1;
  std::atomic<bool> stop_ = false;
  std::atomic<int> callers_ = 0;
  std::thread thread_;
};

}  // namespace tendril::testing_support
