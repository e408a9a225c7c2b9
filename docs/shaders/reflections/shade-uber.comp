// Four materials. Registers and instructions are counted here.
#define ENTRIES 4
#include "reflections/uber.glsl"
