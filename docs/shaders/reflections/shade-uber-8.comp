// Eight materials. Registers and instructions are counted here.
#define ENTRIES 8
#include "reflections/uber.glsl"
