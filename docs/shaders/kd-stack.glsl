// kd-tree with a full stack. An entry is a node and where the ray leaves it.
#include "kd.glsl"
#include "kd-descent.glsl"

bool trace(Ray ray, bool any, inout Hit hit) {
    vec2 span = slab(ray, sceneLow, sceneHigh, hit.t);
    if (span.x > span.y) {
        return false;
    }
    uvec2 stack[64];
    uint top = 0u;
    uint node = 0u;
    for (;;) {
        uvec4 record;
        for (;;) {
            record = nodes[node];
            uint axis = record.y;
            if (axis == LEAF) {
                break;
            }
            float t = (uintBitsToFloat(record.x) - ray.origin[axis]) * ray.inverse[axis];
            bool rightFirst = ray.direction[axis] < 0.0;
            uint near = rightFirst ? record.w : record.z;
            uint far = rightFirst ? record.z : record.w;
            if (t >= span.y) {
                node = near;
            } else if (t <= span.x) {
                node = far;
            } else {
                stack[top] = uvec2(far, floatBitsToUint(span.y));
                top++;
                node = near;
                span.y = t;
            }
        }
        uint last = record.z + record.w;
        for (uint i = record.z; i < last; i++) {
            intersect(references[i], ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        if (hit.t <= span.y || top == 0u) {
            return hit.triangle != NONE;
        }
        top--;
        uvec2 entry = stack[top];
        node = entry.x;
        span = vec2(span.y, uintBitsToFloat(entry.y));
    }
}
