# Writes a C++ file into which the assembler takes the words of a SPIR-V file: cmake -DSPV=in -DNAME=symbol -DHEADER=kernels.h -DOUT=out.cpp -P embed.cmake
# (The compiler needs a second for the same words as an array.)
file(SIZE ${SPV} bytes)
math(EXPR words "${bytes} / 4")
file(WRITE ${OUT} "#include \"${HEADER}\"
asm(R\"(
  .pushsection .rodata
  .balign 4
etendue_${NAME}:
  .incbin \"${SPV}\"
  .popsection
)\");
extern \"C\" const std::uint32_t etendue_${NAME}[];
namespace etendue::kernels {
const std::span<const std::uint32_t> ${NAME}{etendue_${NAME}, ${words}};
}
")
