// Base64 (RFC 4648), as data URIs have it.
#pragma once

#include <string>
#include <string_view>

namespace turner {

std::string base64(std::string_view bytes);

}  // namespace turner
