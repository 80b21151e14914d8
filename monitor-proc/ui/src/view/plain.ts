// The cheap kind of material, for where a program draws: light, tone and colour space
// are computed per vertex, so that a pixel costs one look into the shadow map.
import { type Color, ShaderMaterial, UniformsLib, UniformsUtils } from "three";

const VERTEX = `
  #include <common>
  #include <fog_pars_vertex>
  #include <shadowmap_pars_vertex>
  #include <lights_pars_begin>
  #include <tonemapping_pars_fragment>
  #include <colorspace_pars_fragment>
  uniform vec3 colour;
  uniform vec3 glow;
  uniform float sheen;
  varying vec3 lit;
  varying vec3 shaded;
  vec3 shown(vec3 light) {
    return sRGBTransferOETF(vec4(NeutralToneMapping(light), 1.0)).rgb;
  }
  void main() {
    #include <beginnormal_vertex>
    #include <defaultnormal_vertex>
    #include <begin_vertex>
    #include <project_vertex>
    #include <worldpos_vertex>
    #include <shadowmap_vertex>
    #include <fog_vertex>
    vec3 normal = normalize(transformedNormal);
    vec3 sun = vec3(0.0);
    vec3 rest = vec3(0.0);
    #if NUM_HEMI_LIGHTS > 0
      rest += getHemisphereLightIrradiance(hemisphereLights[0], normal);
    #endif
    #if NUM_DIR_LIGHTS > 0
      // The sun comes first.
      sun = directionalLights[0].color * saturate(dot(normal, directionalLights[0].direction));
    #endif
    #if NUM_DIR_LIGHTS > 1
      rest += directionalLights[1].color * saturate(dot(normal, directionalLights[1].direction));
    #endif
    vec3 paint = colour * RECIPROCAL_PI;
    // What a rough surface mirrors of the sun, most where it is seen flat.
    float grazing = 1.0 - saturate(dot(normal, normalize(-mvPosition.xyz)));
    vec3 mirrored = vec3(sheen * (0.12 + grazing * grazing * grazing));
    lit = shown(glow + mirrored + paint * (rest + sun));
    shaded = shown(glow + paint * rest);
  }`;

const FRAGMENT = `
  #include <common>
  #include <fog_pars_fragment>
  #include <shadowmap_pars_fragment>
  uniform bool receiveShadow;
  varying vec3 lit;
  varying vec3 shaded;
  void main() {
    vec3 seen = lit;
    #if defined(USE_SHADOWMAP) && defined(SHADOWMAP_TYPE_PCF) && NUM_DIR_LIGHT_SHADOWS > 0
      vec3 at = vDirectionalShadowCoord[0].xyz;
      if (receiveShadow && all(greaterThan(at.xy, vec2(0.0))) && all(lessThan(at, vec3(1.0)))) {
        at.z += directionalLightShadows[0].shadowBias;
        seen = mix(shaded, lit, texture(directionalShadowMap[0], at));
      }
    #endif
    gl_FragColor = vec4(seen, 1.0);
    #include <fog_fragment>
  }`;

/** A surface of `colour` that glows by `glow` of it, and mirrors `sheen` of white light where it is seen flat. */
export function plainMaterial(colour: Color, glow: number, sheen: number): ShaderMaterial {
  return new ShaderMaterial({
    lights: true,
    fog: true,
    toneMapped: false,
    uniforms: {
      ...UniformsUtils.merge([UniformsLib.lights, UniformsLib.fog]),
      colour: { value: colour },
      glow: { value: colour.clone().multiplyScalar(glow) },
      sheen: { value: sheen },
    },
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
  });
}
