// What a material of glTF 2.0 makes of ambient light, a sun that throws shadows and LAMPS lamps that
// do not. GGX facets hidden by Smith's term (Heitz 2014), Fresnel by Schlick; light that facets throw
// at each other is made up for (Fdez-Aguera 2019). Colours are linear. What is defined: LIT, COLORED,
// FLAT, TWO_SIDED, FIRST_SET, SECOND_SET, and for each map its name: BASE_MAP, ROUGH_MAP, NORMAL_MAP,
// OCCLUSION_MAP, EMISSION_MAP, whose value is first_set or second_set.

uniform vec4 base_color;
uniform vec3 emission;
uniform float metallic;
uniform float roughness;
uniform float normal_scale;
uniform float occlusion_strength;
#ifdef BASE_MAP
uniform sampler2D base_map;
uniform mat3x2 base_map_place;
#endif
#ifdef ROUGH_MAP
uniform sampler2D metallic_roughness_map;
uniform mat3x2 metallic_roughness_map_place;
#endif
#ifdef NORMAL_MAP
uniform sampler2D normal_map;
uniform mat3x2 normal_map_place;
#endif
#ifdef OCCLUSION_MAP
uniform sampler2D occlusion_map;
uniform mat3x2 occlusion_map_place;
#endif
#ifdef EMISSION_MAP
uniform sampler2D emission_map;
uniform mat3x2 emission_map_place;
#endif

// Texture coordinates, and how they change from pixel to pixel.
struct Place {
    vec2 at;
    vec2 dx;
    vec2 dy;
};

// A point of a surface as it is seen. Changes are from pixel to pixel; `flat_normal` and `normal`
// look to the front.
struct Point {
    vec3 position;
    vec3 dx;
    vec3 dy;
    vec3 flat_normal;
    vec3 normal;
    vec3 normal_dx;
    vec3 normal_dy;
    float side;
    float reach;
    Place first_set;
    Place second_set;
};

Place placed(mat3x2 way, Place given)
{
    mat2 turn = mat2(way[0], way[1]);
    return Place(way * vec3(given.at, 1.0), turn * given.dx, turn * given.dy);
}

// A map read over a share of a pixel.
vec4 read(sampler2D map, Place at, float reach)
{
    return textureGrad(map, at.at, reach * at.dx, reach * at.dy);
}

#ifdef LIT
uniform vec3 eye;
uniform vec3 ambient;
uniform vec3 around[9];
uniform vec3 to_sun;
uniform vec3 sun;
uniform mat4 light_from_world;
uniform sampler2DShadow shadow_map;
uniform sampler2D mirrored_table;
#if LAMPS > 0
uniform vec3 lamp_position[LAMPS];
uniform vec3 lamp[LAMPS];
#endif

const float PI = 3.141592653589793;
// Mirrors of a dielectric at normal incidence, and the smoothest surface that is drawn: smoother
// ones would show a highlight smaller than a pixel.
const float MIRRORED = 0.04;
const float SMOOTHEST = 0.0525;

struct Facets {
    vec3 diffuse;
    vec3 mirrored;
    float rough;
};

// Scale and offset of the mirrored colour under even light.
vec2 even(float rough, float nv)
{
    return texture(mirrored_table, vec2(rough, nv)).rg;
}

vec3 reflected(vec3 n, vec3 v, vec3 l, Facets facets)
{
    vec3 h = normalize(l + v);
    float nl = clamp(dot(n, l), 0.0, 1.0);
    float nv = clamp(dot(n, v), 0.0, 1.0);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    float away = 1.0 - clamp(dot(v, h), 0.0, 1.0);
    float away2 = away * away;
    vec3 fresnel = facets.mirrored + (1.0 - facets.mirrored) * (away2 * away2 * away);
    float a = facets.rough * facets.rough;
    float a2 = a * a;
    float seen = nl * sqrt(a2 + (1.0 - a2) * nv * nv) + nv * sqrt(a2 + (1.0 - a2) * nl * nl);
    float spread = nh * nh * (a2 - 1.0) + 1.0;
    vec3 once = fresnel * (0.5 / max(seen, 1e-6)) * (a2 / (PI * spread * spread));
    vec2 from_eye = even(facets.rough, nv);
    vec2 from_light = even(facets.rough, nl);
    float lost = (1.0 - from_eye.x - from_eye.y) * (1.0 - from_light.x - from_light.y);
    vec3 mean = facets.mirrored + (1.0 - facets.mirrored) / 21.0;
    vec3 again = (facets.mirrored * from_eye.x + from_eye.y)
        * (facets.mirrored * from_light.x + from_light.y) * mean / (1.0 - lost * mean + 1e-6);
    return nl * ((1.0 - fresnel) * facets.diffuse / PI + once + again * lost);
}

// Share of even light that facets mirror, thrown at each other or not.
vec3 mirrored_evenly(Facets facets, float nv)
{
    vec2 both = even(facets.rough, nv);
    vec3 once = facets.mirrored * both.x + both.y;
    float lost = 1.0 - both.x - both.y;
    vec3 mean = facets.mirrored + (1.0 - facets.mirrored) / 21.0;
    return once + once * mean * lost / (1.0 - lost * mean);
}

// Light from all around as spherical harmonics to band 2, of which a lobe about n lets pass a share.
vec3 arriving(vec3 n, float first, float second)
{
    vec3 light = 0.28209479 * around[0]
        + first * 0.48860251 * (n.y * around[1] + n.z * around[2] + n.x * around[3])
        + second * (1.09254843 * (n.x * n.y * around[4] + n.y * n.z * around[5]
                                  + n.x * n.z * around[7])
                    + 0.31539157 * (3.0 * n.z * n.z - 1.0) * around[6]
                    + 0.54627422 * (n.x * n.x - n.y * n.y) * around[8]);
    return max(light, vec3(0.0));
}

// Share of the sun that arrives: four bilinear comparisons, three by three texels wide.
float sunlit(vec3 position, float nl)
{
    vec3 place_in_light = (light_from_world * vec4(position, 1.0)).xyz * 0.5 + 0.5;
    if (any(greaterThan(abs(place_in_light - 0.5), vec3(0.5)))) {
        return 1.0;
    }
    float bias = max(0.001 * (1.0 - nl), 0.0001);
    vec2 texel = 0.5 / vec2(textureSize(shadow_map, 0));
    float depth = place_in_light.z - bias;
    float seen = texture(shadow_map, vec3(place_in_light.xy + vec2(-texel.x, -texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(texel.x, -texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(-texel.x, texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(texel.x, texel.y), depth));
    return 0.25 * seen;
}

#ifdef NORMAL_MAP
// The map's normal in the world. Tangents come from how place and coordinates change between pixels
// (Mikkelsen 2013, "Followup: Normal Mapping Without Precomputed Tangents").
vec3 bent(vec3 n, Point p)
{
    Place at = placed(normal_map_place, p.NORMAL_MAP);
    vec3 along = cross(p.dy, n);
    vec3 across = cross(n, p.dx);
    vec3 t = along * at.dx.x + across * at.dy.x;
    vec3 b = along * at.dx.y + across * at.dy.y;
    float size = max(dot(t, t), dot(b, b));
    float scale = size == 0.0 ? 0.0 : p.side * inversesqrt(size);
    vec3 own = read(normal_map, at, p.reach).xyz * 2.0 - 1.0;
    own.xy *= normal_scale * vec2(1.0, -1.0);
    return normalize(t * scale * own.x + b * scale * own.y + n * own.z);
}
#endif

vec3 lit(vec3 base, Point p)
{
    float metal = metallic;
    float rough = roughness;
#ifdef ROUGH_MAP
    vec4 given = read(metallic_roughness_map, placed(metallic_roughness_map_place, p.ROUGH_MAP),
                      p.reach);
    rough *= given.g;
    metal *= given.b;
#endif
#ifdef FLAT
    vec3 n = p.side * p.flat_normal;
    rough = max(rough, SMOOTHEST);
#else
    vec3 n = p.side * p.normal;
    vec3 change = 0.5 * max(abs(p.normal_dx), abs(p.normal_dy));
    rough = min(max(rough, SMOOTHEST) + max(max(change.x, change.y), change.z), 1.0);
#endif
#ifdef NORMAL_MAP
    n = bent(n, p);
#endif
    Facets facets = Facets(base * (1.0 - metal), mix(vec3(MIRRORED), base, metal), rough);
    vec3 v = normalize(eye - p.position);
    float open = 1.0;
#ifdef OCCLUSION_MAP
    open = 1.0 + occlusion_strength
        * (read(occlusion_map, placed(occlusion_map_place, p.OCCLUSION_MAP), p.reach).r - 1.0);
#endif
    vec3 mirrored = mirrored_evenly(facets, clamp(dot(n, v), 0.0, 1.0));
    // A clamped cosine lets pass 2/3 and 1/4; facets whose slopes vary by a / sqrt(2), and so what
    // they mirror by twice that, as heat would spread.
    float a = rough * rough;
    float spread = exp(-2.0 * a * a);
    vec3 light = facets.diffuse * (1.0 - mirrored) * (ambient + arriving(n, 2.0 / 3.0, 0.25));
    light += mirrored * arriving(reflect(-v, n), spread, spread * spread * spread);
    light *= open;
    float nl = dot(n, to_sun);
    if (nl > 0.0) {
        light += sun * reflected(n, v, to_sun, facets) * sunlit(p.position, nl);
    }
#if LAMPS > 0
    for (int i = 0; i < LAMPS; ++i) {
        vec3 way = lamp_position[i] - p.position;
        float square = dot(way, way);
        light += lamp[i] / square * reflected(n, v, way * inversesqrt(square), facets);
    }
#endif
    vec3 own = emission;
#ifdef EMISSION_MAP
    own *= read(emission_map, placed(emission_map_place, p.EMISSION_MAP), p.reach).rgb;
#endif
    return light + own;
}
#endif
