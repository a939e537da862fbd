// A path's decisions folded into 32 bits; docs/conventions.md, "Path signature".
#ifndef SIGNATURE_GLSL
#define SIGNATURE_GLSL

const uint kSignatureStart = 0x811c9dc5u;

uint fold_word(uint signature, uint word) { return (signature ^ word) * 0x01000193u; }

uint fold_decisions(uint h, Decisions d) {
  if (d.instance == kNone) return fold_word(h, 0u);
  h = fold_word(fold_word(h, d.instance + 1u), d.primitive + 1u);
  if (d.light_instance != kNone) {
    h = fold_word(fold_word(fold_word(h, d.light_instance + 1u), d.light_primitive + 1u), d.light_contributed);
  }
  if (d.lobe != kNone) h = fold_word(h, d.lobe);
  if (d.survived != kNone) h = fold_word(h, d.survived);
  return h;
}

#endif
