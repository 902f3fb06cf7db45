# Writes a header with one std::string_view per file; see cairn_embed in CairnTargets.cmake.
string(REPLACE "," ";" files "${FILES}")
set(text "// Generated; do not edit.\n#pragma once\n\n#include <string_view>\n\nnamespace ${NAMESPACE} {\n\n")
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  string(REGEX REPLACE "[^A-Za-z0-9]" "_" name ${name})
  file(READ ${file} bytes HEX)
  string(LENGTH "${bytes}" num_digits)
  math(EXPR num_bytes "${num_digits} / 2")
  # An array of characters, not a literal: literals have a length limit.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND text "inline constexpr char k_${name}_bytes[] = {${bytes}'\\0'};\n"
                     "inline constexpr std::string_view k_${name}(k_${name}_bytes, ${num_bytes});\n\n")
endforeach()
string(APPEND text "}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUT} "${text}")
