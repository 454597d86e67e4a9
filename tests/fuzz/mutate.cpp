#include "mutate.hpp"

#include "tremula/numerics/random.hpp"

#include <algorithm>

namespace tremula::fuzz {
namespace {

struct Dice {
  std::uint64_t number;
  std::uint64_t thrown = 0;

  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(uniform({number, RandomStream::test, 0, thrown++}) *
                                    static_cast<double>(count));
  }
};

struct Piece {
  std::size_t begin, size;
};

Piece piece_of(const std::string& bytes, Dice& dice) {
  const std::size_t begin = dice.below(bytes.size() + 1);
  const std::size_t longest = std::min<std::size_t>(bytes.size() - begin, std::size_t{1} << dice.below(8));
  return {begin, dice.below(longest + 1)};
}

void change(std::string& bytes, const std::vector<std::string>& seeds, const std::vector<std::string>& words,
            Dice& dice) {
  const Piece piece = piece_of(bytes, dice);
  const std::string copy = bytes.substr(piece.begin, piece.size);
  switch (dice.below(8)) {
    case 0:
      if (!bytes.empty()) bytes[dice.below(bytes.size())] ^= static_cast<char>(1U << dice.below(8));
      break;
    case 1:
      if (!bytes.empty()) bytes[dice.below(bytes.size())] = static_cast<char>(dice.below(256));
      break;
    case 2:
      bytes.insert(piece.begin, copy);
      break;
    case 3:
      bytes.erase(piece.begin, piece.size);
      break;
    case 4:
      bytes.erase(piece.begin, piece.size);
      bytes.insert(dice.below(bytes.size() + 1), copy);
      break;
    case 5: {
      const std::string& other = seeds[dice.below(seeds.size())];
      const Piece from = piece_of(other, dice);
      bytes.replace(piece.begin, piece.size, other, from.begin, from.size);
      break;
    }
    case 6:
      bytes.insert(piece.begin, words[dice.below(words.size())]);
      break;
    default: {
      const std::string& word = words[dice.below(words.size())];
      bytes.replace(piece.begin, std::min(word.size(), bytes.size() - piece.begin), word);
      break;
    }
  }
}

}  // namespace

std::string mutant(const std::vector<std::string>& seeds, const std::vector<std::string>& words,
                   std::uint64_t number) {
  Dice dice{number};
  std::string bytes = seeds[dice.below(seeds.size())];
  const std::size_t changes = 1 + dice.below(6);
  for (std::size_t i = 0; i < changes; ++i) change(bytes, seeds, words, dice);
  return bytes;
}

}  // namespace tremula::fuzz
