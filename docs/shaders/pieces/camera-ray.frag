// [shared] camera_ray: pixel to direction.
#include "shared.glsl"
#include "camera.glsl"

out vec3 result;

void main() {
    result = cameraDirection(gl_FragCoord.xy);
}
