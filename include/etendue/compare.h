#pragma once
/// How far apart two pictures are, and whether chance explains it: compare_images().

#include "validate/compare.h"
