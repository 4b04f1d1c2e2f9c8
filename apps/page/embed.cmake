# cmake -DHEADER=apps/page/assets.hpp -DNAMES=a;b -DFILES=a.js;b.css -DOUTPUT=assets.cpp -P embed.cmake: texts as constants
# of a C++ file, returned by the functions NAMES that HEADER declares.
set(code "#include \"${HEADER}\"\n\nnamespace apps {\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ "${file}" hex HEX)
  string(LENGTH "${hex}" length)
  math(EXPR count "${length} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
  string(REGEX REPLACE "(('[^,]*',){32})" "\\1\n" bytes "${bytes}")
  string(APPEND code "namespace {\nconstexpr char ${name}_bytes[] = {${bytes}};\n}  // namespace\n"
                     "std::string_view ${name}() { return {${name}_bytes, ${count}}; }\n")
endforeach()
file(WRITE "${OUTPUT}" "${code}}  // namespace apps\n")
