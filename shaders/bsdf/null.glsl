// Nothing at all. Paths pass it without asking it; only who looks at materials by themselves does.

BsdfSample null_sample(vec3 wo) { return BsdfSample(-wo, 1.0, vec3(1.0), kLobeDeltaTransmission, 1.0); }
