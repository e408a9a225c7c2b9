// kd push-down (Horn et al. 2007), with a short stack of SHORT_STACK entries or none: starts again at the lowest node that holds the
// whole rest of the ray.
#include "kd.glsl"
#include "kd-descent.glsl"

bool trace(Ray ray, bool any, inout Hit hit) {
    vec2 span = slab(ray, sceneLow, sceneHigh, hit.t);
    if (span.x > span.y) {
        return false;
    }
#if SHORT_STACK > 0
    // A ring of the latest far children.
    uvec2 stack[SHORT_STACK];
    uint depth = 0u;
    uint kept = 0u;
#endif
    float end = span.y;
    uint node = 0u;
    uint start = 0u;
    bool pushDown = true;
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
#if SHORT_STACK > 0
                stack[depth % uint(SHORT_STACK)] = uvec2(far, floatBitsToUint(span.y));
                depth++;
                kept = min(kept + 1u, uint(SHORT_STACK));
#endif
                node = near;
                span.y = t;
                pushDown = false;
            }
            if (pushDown) {
                start = node;
            }
        }
        uint last = record.z + record.w;
        for (uint i = record.z; i < last; i++) {
            intersect(references[i], ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        if (hit.t <= span.y || span.y >= end) {
            return hit.triangle != NONE;
        }
#if SHORT_STACK > 0
        if (kept > 0u) {
            kept--;
            depth--;
            uvec2 entry = stack[depth % uint(SHORT_STACK)];
            node = entry.x;
            span = vec2(span.y, uintBitsToFloat(entry.y));
            continue;
        }
#endif
        node = start;
        span = vec2(span.y, end);
        pushDown = true;
    }
}
