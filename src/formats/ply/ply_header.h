#pragma once
/// What a PLY file says it holds [Turk1994].

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/ply/ply_stream.h"
#include "scene/diagnostics.h"

namespace etendue {

struct PlyProperty {
  std::string name;
  PlyType type;
  std::optional<PlyType> count_type;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  SourcePosition position;

  bool has_lists() const;
  /// Bytes of one in a binary file, a list without items counting by its count.
  std::size_t least_size() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
};

/// Reads up to the line end_header and leaves the stream at the data. Throws PlyError; warns of lines that are not
/// known.
PlyHeader read_ply_header(PlyStream& stream, Diagnostics& diagnostics);

}  // namespace etendue
