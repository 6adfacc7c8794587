// Files are read to the last byte, whatever their size is said to be, and hashed as others do.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/errors.h"
#include "base/text_file.h"

namespace turner {
namespace {

TEST(TextFile, EveryByteIsRead) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("turner_text_file_" + std::to_string(getpid()));
  for (const size_t size : {0, 1, 4095, 4096, 65536, 3'000'001}) {
    std::string text(size, '\0');
    for (size_t i = 0; i < size; ++i) text[i] = char(i * 7 + i / 256);
    std::ofstream(path, std::ios::binary) << text;
    EXPECT_TRUE(readTextFile(path.string()) == text) << size << " bytes";
  }
  std::filesystem::remove(path);
}

TEST(TextFile, FilesWithoutASizeAreReadToTheirEnd) {
  const std::string path = "/proc/self/status";
  ASSERT_EQ(std::filesystem::file_size(path), 0u);
  EXPECT_NE(readTextFile(path).find("nonvoluntary_ctxt_switches"), std::string::npos) << "that is its last line";
}

std::string refusal(const std::string& path) {
  try {
    readTextFile(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(TextFile, WhatCannotBeReadIsNamed) {
  EXPECT_EQ(refusal("no/such/file"), "no/such/file: error: cannot open: No such file or directory");
  EXPECT_EQ(refusal("/"), "/: error: is a folder, not a file");
}

TEST(TextFile, HashesAreThoseOfTheStandard) {
  EXPECT_EQ(sha256Hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256Hex(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace turner
