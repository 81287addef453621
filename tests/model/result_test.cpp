// model/result.h: an error says where it happened, outermost first.
#include "model/result.h"

#include <gtest/gtest.h>

namespace tendril {
namespace {

TEST(Result, WithinAddsTheOuterPlaceInFront) {
  Result<int> inner = Error{ErrorKind::kIo, "frame 812 is truncated"};
  const Error outer = std::move(inner).error().Within("cam1.mkv").Within("trial 7");
  EXPECT_EQ(outer.message, "trial 7: cam1.mkv: frame 812 is truncated");
  EXPECT_EQ(outer.kind, ErrorKind::kIo);
}

}  // namespace
}  // namespace tendril
