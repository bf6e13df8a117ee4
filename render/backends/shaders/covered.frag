// The number of a triangle, from 1; 0 is none. Where MASKED is defined, samples are drawn one at a
// time, and what lies below the cutoff there is left out.

uniform uint first;
out uint number;
#ifdef MASKED
uniform vec2 sample_place;
uniform float base_alpha;
uniform float alpha_cutoff;
#ifdef COLORED
in vec4 color;
#endif
#ifdef BASE_MAP
uniform sampler2D base_map;
uniform mat3x2 base_map_place;
in vec2 place;
#endif
#endif

void main()
{
#ifdef MASKED
    float alpha = base_alpha;
#ifdef COLORED
    alpha *= color.a;
#endif
#ifdef BASE_MAP
    vec2 at = base_map_place * vec3(place, 1.0);
    vec2 dx = dFdx(at);
    vec2 dy = dFdy(at);
    vec2 off = sample_place - 0.5;
    alpha *= textureGrad(base_map, at + off.x * dx + off.y * dy, 0.5 * dx, 0.5 * dy).a;
#endif
    if (alpha < alpha_cutoff) {
        discard;
    }
#endif
    number = first + uint(gl_PrimitiveID);
}
