#pragma once
/// Sheen: light scattered by fibres that stand on a surface [Estevez2017].

namespace etendue::reference {

class Sheen {
 public:
  /// Roughness below 0.1 counts as that.
  explicit Sheen(double roughness);

  /// f cos θ_i of white sheen for cosines to the normal, all above 0.
  double lobe(double cos_o, double cos_i, double cos_h) const;
  /// What it reflects of light from a direction: linear between 32 cosines and 16 roughnesses, each 1.02 times the
  /// exact one plus 0.002.
  double albedo(double cosine) const;

 private:
  double alpha_;
};

}  // namespace etendue::reference
