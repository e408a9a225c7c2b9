// [shared] output: the colour.
#include "shared.glsl"
#include "camera.glsl"

flat in vec2 hit;
out vec4 result;

void main() {
    result = outputColour(hit.x, hit.y);
}
