#include "tremula/io/foreign_files.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace tremula {
namespace {

struct Kind {
  const char* found = nullptr;
  const char* wanted = nullptr;
};

constexpr const char* a_model =
    "a tree as cylinders or nodes: fit one to it first (TreeQSM, SimpleForest, rayextract trees)";
constexpr const char* unpacked = "the file that is packed in it";

struct Signature {
  std::string_view bytes;
  Kind kind;
};

constexpr std::array signatures = {
    Signature{"ply\n", {"a PLY file: a mesh or a point cloud is no tree model yet", a_model}},
    Signature{"ply\r", {"a PLY file: a mesh or a point cloud is no tree model yet", a_model}},
    Signature{"LASF", {"a LAS or LAZ file: a point cloud is no tree model yet", a_model}},
    Signature{"ASTM-E57", {"an E57 file: a point cloud is no tree model yet", a_model}},
    Signature{"# .PCD", {"a PCD file: a point cloud is no tree model yet", a_model}},
    Signature{"glTF", {"a glTF file: a mesh is no tree model", a_model}},
    Signature{"Kaydara FBX", {"an FBX file: a mesh is no tree model", a_model}},
    Signature{"BLENDER", {"a Blender file: a mesh is no tree model", a_model}},
    Signature{"PK\x03\x04", {"a zip archive (also .xlsx and .npz are)", unpacked}},
    Signature{"\x1F\x8B", {"a file packed with gzip (also R's .rds are)", unpacked}},
    Signature{"BZh", {"a file packed with bzip2", unpacked}},
    Signature{"\xFD"
              "7zXZ",
              {"a file packed with xz", unpacked}},
    Signature{"RDX", {"an R data file", "a table: write.csv(cylinder, ...)"}},
    Signature{"\x93NUMPY", {"a NumPy array", "a table of text"}},
    Signature{"\xFF\xFE", {"text in UTF-16", "text in UTF-8"}},
    Signature{"\xFE\xFF", {"text in UTF-16", "text in UTF-8"}},
    Signature{"%PDF", {"a PDF", "a tree"}},
    Signature{"\x89PNG", {"a picture", "a tree"}},
    Signature{"\xFF\xD8\xFF", {"a picture", "a tree"}},
};

bool is_binary_stl(std::string_view bytes) {
  if (bytes.size() < 134 || (bytes.size() - 84) % 50 != 0) return false;
  std::uint32_t triangles = 0;
  for (std::size_t i = 0; i < 4; ++i)
    triangles |= std::uint32_t{static_cast<unsigned char>(bytes[80 + i])} << (8 * i);
  return triangles == (bytes.size() - 84) / 50;
}

// By the first lines of a text, comments passed over.
Kind kind_of_text(std::string_view text) {
  TextLines lines{text.substr(0, 65536)};
  std::string_view line;
  for (int looked_at = 0; looked_at < 50 && lines.next(line);) {
    if (line.empty() || line[0] == '#') continue;
    const Fields fields = split_at_blanks(line);
    if (fields.count == 0) continue;
    const std::string_view word = fields.at[0];
    if (++looked_at == 1) {
      if (word.starts_with('{') || word.starts_with('['))
        return {"a JSON file", "a table: of treegraph's models, the cylinders (cyls) written as CSV"};
      if (word.starts_with('<'))
        return {"an XML file", "a tree as a table of cylinders or nodes, or an L-system (.lsys)"};
      if (word == "solid" && text.substr(0, 65536).find("facet") != std::string_view::npos)
        return {"an STL file: a mesh is no tree model", a_model};
    }
    if (word == "VERSION" && text.substr(0, 65536).find("FIELDS") != std::string_view::npos)
      return {"a PCD file: a point cloud is no tree model yet", a_model};
    if (word == "mtllib" || word == "usemtl" || word == "vn" || word == "vt" ||
        ((word == "v" || word == "f") && fields.count >= 4))
      return {"an OBJ file: a mesh is no tree model", a_model};
    if (word.starts_with("CODE") && line.find(':') != std::string_view::npos)
      return {"a multiscale tree graph (MTG), which is not read yet",
              "a table of cylinders or nodes with positions and radii"};
    if (word.starts_with("axiom:")) return {"an L-system", "a name that ends in .lsys"};
    if (word.starts_with("Axiom:") || word.starts_with("production") || line.starts_with("derivation length"))
      return {"an L-Py model, which needs L-Py to run", "an L-system of tremula (docs/guide/growing.md)"};
  }
  return {};
}

}  // namespace

void reject_foreign_file(std::string_view bytes, const std::string& path) {
  const auto signature = std::find_if(signatures.begin(), signatures.end(),
                                      [&](const Signature& s) { return bytes.starts_with(s.bytes); });
  Kind kind;
  if (signature != signatures.end()) {
    kind = signature->kind;
  } else if (is_binary_stl(bytes)) {
    kind = {"an STL file: a mesh is no tree model", a_model};
  } else {
    kind = kind_of_text(bytes);
  }
  if (kind.found != nullptr) throw InputError(path, kind.found, kind.wanted);
}

}  // namespace tremula
