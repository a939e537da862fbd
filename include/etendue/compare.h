#pragma once
/// How far apart two pictures are, and whether chance explains the difference: compare_images().

#include "validate/compare.h"
