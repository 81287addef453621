// db/files/page_text.h: text that cannot become markup, and RFC 4648's own examples.
#include "db/files/page_text.h"

#include <gtest/gtest.h>

namespace tendril {
namespace {

TEST(XmlText, MarkupBecomesTextAndControlCharactersBlanks) {
  EXPECT_EQ(XmlText("<b>&\"'\x01\tx"), "&lt;b&gt;&amp;&quot;&#39; \tx");
  EXPECT_EQ(XmlText("\u00e4\u2192"), "\u00e4\u2192");
  EXPECT_EQ(XmlText(""), "");
}

TEST(Base64, IsAsTheStandardsExamples) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64(std::string("\xff\x00\xfe", 3)), "/wD+");
}

}  // namespace
}  // namespace tendril
