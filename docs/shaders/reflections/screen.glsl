// Lines on the screen. Depth is the near plane's distance over the point's: nearer is larger, and it is linear along a line on the screen.

layout(std430, binding = 3) buffer Rays {
    vec4 rays[];
};

// The stand-alone compiler cannot compile texture reads. A texture takes the two coordinates; what makes an index of them is not counted.
layout(std430, binding = 4) readonly buffer Depths {
    float depths[];
};

// From the world to pixels and depth, times w.
uniform mat4 transform;
uniform vec2 size;
uniform uint width;
uniform float perStride;
// A surface hides what is behind it up to this part of its depth.
uniform float thickness;

struct Line {
    vec3 start;
    vec3 delta;
    // Part of `delta` that is on the screen.
    float end;
};

// The line of a ray up to `reach`.
Line screenLine(vec3 origin, vec3 direction, float reach) {
    // The standalone compiler does not know products of matrix and vector.
    vec4 from = transform[0] * origin.x + transform[1] * origin.y + transform[2] * origin.z + transform[3];
    vec4 along = transform[0] * direction.x + transform[1] * direction.y + transform[2] * direction.z;
    vec4 to = from + along * reach;
    vec3 start = from.xyz / from.w;
    vec3 delta = to.xyz / to.w - start;
    vec2 inverse = 1.0 / delta.xy;
    vec2 border = vec2(delta.x > 0.0 ? size.x : 0.0, delta.y > 0.0 ? size.y : 0.0);
    vec2 exit = (border - start.xy) * inverse;
    return Line(start, delta, min(min(exit.x, exit.y), 1.0));
}
