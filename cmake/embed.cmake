# Writes the words of a SPIR-V file as a C++ array: cmake -DSPV=in -DNAME=symbol -DHEADER=kernels.h -DOUT=out.cpp -P embed.cmake
file(READ ${SPV} hex HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${hex}")
file(WRITE ${OUT} "#include \"${HEADER}\"
namespace etendue::kernels {
static constexpr std::uint32_t ${NAME}_words[] = {
${words}};
const std::span<const std::uint32_t> ${NAME}{${NAME}_words};
}
")
