#pragma once
// Text and bytes as they go into XML, SVG and HTML.

#include <string>
#include <string_view>

namespace tendril {

// Any UTF-8 text as the content of an element or of a quoted attribute; control characters become blanks.
std::string XmlText(std::string_view text);

// RFC 4648, with padding, without line breaks.
std::string Base64(std::string_view bytes);

}  // namespace tendril
