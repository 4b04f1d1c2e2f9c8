#include "dsp/io/digest.hpp"

#include <catch2/catch.hpp>
#include <string>

using Method = dsp::Digest::Method;

namespace {

std::string digest(Method method, const std::string& first, const std::string& second) {
  dsp::Digest of(method);
  of.push(first);
  of.push(second);
  std::string text;
  for (const char byte : of.finish()) {
    constexpr const char* digits = "0123456789abcdef";
    text += digits[static_cast<unsigned char>(byte) >> 4];
    text += digits[static_cast<unsigned char>(byte) & 15];
  }
  return text;
}

}  // namespace

TEST_CASE("digests are those published with the methods, however the bytes come", "[dsp][digest]") {
  // RFC 1321, A.5, and FIPS 180-2, B.1.
  CHECK(digest(Method::md5, "", "") == "d41d8cd98f00b204e9800998ecf8427e");
  CHECK(digest(Method::md5, "a", "bc") == "900150983cd24fb0d6963f7d28e17f72");
  CHECK(digest(Method::sha256, "abc", "") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}
