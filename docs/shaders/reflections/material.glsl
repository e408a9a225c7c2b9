// What shades a hit: attributes of its triangle, and its material under one light.

// By instance: first index, first vertex, shader and material.
layout(std430, binding = 12) readonly buffer Instances {
    uvec4 meshes[];
};

layout(std430, binding = 13) readonly buffer Indices {
    uvec4 corners[];
};

// Normal, and two texture coordinates of 16 bits.
layout(std430, binding = 14) readonly buffer Vertices {
    vec4 vertices[];
};

// Albedo and roughness; emission and reflectance at a right angle.
layout(std430, binding = 15) readonly buffer Materials {
    vec4 materials[];
};

struct Surface {
    vec3 normal;
    vec2 uv;
};

vec2 coordinates(vec4 vertex) {
    uint bits = floatBitsToUint(vertex.w);
    return vec2(float(bits & 0xFFFFu), float(bits >> 16)) * (1.0 / 65535.0);
}

Surface fetchSurface(uvec4 mesh, uint triangle, float u, float v) {
    uvec4 corner = corners[mesh.x + triangle] + mesh.y;
    vec4 v0 = vertices[corner.x];
    vec4 v1 = vertices[corner.y];
    vec4 v2 = vertices[corner.z];
    float w = 1.0 - u - v;
    vec3 normal = normalize(w * v0.xyz + u * v1.xyz + v * v2.xyz);
    return Surface(normal, w * coordinates(v0) + u * coordinates(v1) + v * coordinates(v2));
}

// Lambert and GGX with the visibility term of Karis 2013 and the Fresnel term of Schlick 1994.
vec3 shadeGlossy(vec4 base, vec4 more, vec3 normal, vec3 toLight, vec3 toViewer) {
    vec3 middle = normalize(toLight + toViewer);
    float nl = max(dot(normal, toLight), 0.0);
    float nv = max(dot(normal, toViewer), 1e-4);
    float nh = max(dot(normal, middle), 0.0);
    float lh = max(dot(toLight, middle), 0.0);
    float alpha = base.w * base.w;
    float squared = alpha * alpha;
    float spread = nh * nh * (squared - 1.0) + 1.0;
    float half_k = alpha * 0.5;
    float shadowing = (nl * (1.0 - half_k) + half_k) * (nv * (1.0 - half_k) + half_k);
    float away = 1.0 - lh;
    float fresnel = more.w + (1.0 - more.w) * (away * away) * (away * away) * away;
    float glossy = squared * fresnel / (12.566371 * spread * spread * shadowing);
    return (base.xyz * 0.31830989 + glossy) * nl;
}

vec3 shadeDiffuse(vec4 base, vec3 normal, vec3 toLight) {
    return base.xyz * (0.31830989 * max(dot(normal, toLight), 0.0));
}
