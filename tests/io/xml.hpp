// A strict reader of the XML that the program writes: elements, attributes, text. Throws where it is not well
// formed.
#pragma once

#include <cctype>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace tremula::test {

struct XmlElement {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::string text;

  double number(const std::string& attribute) const { return std::stod(attributes.at(attribute)); }
};

// All elements in the order in which they begin.
class XmlReader {
 public:
  explicit XmlReader(const std::string& source) : source_(source) {
    if (starts_with("<?xml")) at_ = source_.find("?>") + 2;
    skip_space();
    read_element();
    skip_space();
    if (at_ != source_.size()) fail("something after the end");
  }
  std::vector<XmlElement> elements;

 private:
  void read_element() {
    expect('<');
    const std::size_t self = elements.size();
    const std::string name = read_name();
    elements.push_back({name, {}, ""});
    for (skip_space(); peek() != '>' && peek() != '/'; skip_space()) {
      const std::string attribute = read_name();
      expect('=');
      expect('"');
      if (!elements[self].attributes.emplace(attribute, read_text('"')).second) fail("twice " + attribute);
      expect('"');
      if (!std::isspace(static_cast<unsigned char>(peek())) && peek() != '>' && peek() != '/') {
        fail("no space between attributes");
      }
    }
    if (peek() == '/') {
      ++at_;
      return expect('>');
    }
    expect('>');
    while (!starts_with("</")) {
      elements[self].text += read_text('<');
      if (!starts_with("</")) read_element();
    }
    at_ += 2;
    if (read_name() != name) fail("wrong end of " + name);
    expect('>');
  }

  std::string read_text(char end) {
    std::string text;
    while (peek() != end) {
      if (peek() == '<') fail("< inside of text");
      if (static_cast<unsigned char>(peek()) < 0x20 && peek() != '\n' && peek() != '\t')
        fail("control character");
      if (peek() != '&') {
        text += source_[at_++];
        continue;
      }
      static const std::map<std::string, char> entities{
          {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
      const std::string entity = source_.substr(at_, source_.find(';', at_) + 1 - at_);
      if (!entities.contains(entity)) fail("no entity " + entity.substr(0, 10));
      text += entities.at(entity);
      at_ += entity.size();
    }
    return text;
  }

  std::string read_name() {
    const std::size_t begin = at_;
    while (std::isalnum(static_cast<unsigned char>(peek())) || peek() == '-') ++at_;
    if (at_ == begin) fail("no name");
    return source_.substr(begin, at_ - begin);
  }

  char peek() const {
    if (at_ >= source_.size()) fail("end of the text");
    return source_[at_];
  }
  void expect(char c) {
    if (peek() != c) fail(std::string("no ") + c);
    ++at_;
  }
  void skip_space() {
    while (at_ < source_.size() && std::isspace(static_cast<unsigned char>(source_[at_]))) ++at_;
  }
  bool starts_with(const std::string& what) const { return source_.compare(at_, what.size(), what) == 0; }
  [[noreturn]] void fail(const std::string& why) const {
    throw std::runtime_error("not XML at " + std::to_string(at_) + ": " + why);
  }

  std::string source_;
  std::size_t at_ = 0;
};

inline std::vector<XmlElement> read_xml(const std::string& source) { return XmlReader(source).elements; }

}  // namespace tremula::test
