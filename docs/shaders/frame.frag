// A whole frame in one fragment shader: primary ray, shading, shadow ray. Registers are counted here.
#include "shared.glsl"
#include TRAVERSAL
#include "camera.glsl"

out vec4 colour;

void main() {
    vec3 direction = cameraDirection(gl_FragCoord.xy);
    Hit hit = Hit(1e30, 0.0, 0.0, NONE);
    float lit = 0.0;
    float visibility = 0.0;
    if (trace(makeRay(eye, direction), false, hit)) {
        uint first = 6u * hit.triangle;
        vec3 n0 = triangles[first + 3u].xyz;
        vec3 n1 = triangles[first + 4u].xyz;
        vec3 n2 = triangles[first + 5u].xyz;
        vec3 normal = hitNormal(n0, n1, n2, hit.u, hit.v);
        vec3 origin = shadowOrigin(hitPoint(eye, direction, hit.t), normal, direction);
        vec3 toLight = light - origin;
        lit = max(dot(normal, normalize(toLight)), 0.0);
        Hit blocker = Hit(1.0, 0.0, 0.0, NONE);
        visibility = trace(makeRay(origin, toLight), true, blocker) ? 0.0 : 1.0;
    }
    colour = outputColour(lit, visibility);
}
