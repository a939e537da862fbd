// No scattering at all. Paths pass such surfaces without calling this; only probes of single materials do.

BsdfSample null_sample(vec3 wo) { return BsdfSample(-wo, 1.0, vec3(1.0), kLobeDeltaTransmission, 1.0); }
