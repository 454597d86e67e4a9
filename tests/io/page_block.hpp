// The block of a page, read as the description in io/page_block.hpp says.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tremula::test {

struct PageBlock {
  nlohmann::json head;
  std::string numbers;

  PageBlock(std::string_view letters, const std::string& bytes) {
    EXPECT_EQ(bytes.substr(0, 4), letters);
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 4, 4);
    EXPECT_EQ(length % 4, 0U);
    head = nlohmann::json::parse(bytes.substr(8, length));
    numbers = bytes.substr(8 + length);
  }
  template <class T>
  std::vector<T> values(const char* part, std::size_t count) const {
    std::vector<T> result(count);
    const std::size_t first = head[part]["first_byte"];
    EXPECT_LE(first + count * sizeof(T), numbers.size());
    std::memcpy(result.data(), numbers.data() + first, count * sizeof(T));
    return result;
  }
};

}  // namespace tremula::test
