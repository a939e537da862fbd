# Writes the bytes of a file as a C++ array: cmake -DTEXT=in -DNAME=symbol -DOUT=out.cpp -P embed_text.cmake
file(READ ${TEXT} hex HEX)
string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${hex}")
string(REGEX REPLACE "('[^']*',)('[^']*',)('[^']*',)('[^']*',)('[^']*',)('[^']*',)('[^']*',)('[^']*',)" "\\1\\2\\3\\4\\5\\6\\7\\8\n" bytes "${bytes}")
file(WRITE ${OUT} "#include \"report_assets.h\"
namespace etendue::assets {
static constexpr char ${NAME}_bytes[] = {
${bytes}'\\0'};
const std::string_view ${NAME}{${NAME}_bytes, sizeof(${NAME}_bytes) - 1};
}
")
