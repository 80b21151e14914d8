// Keys and values that a JSON Schema knows, for the completion of the editor.

export interface Words {
  /** Keys by name, with what the schema says about them. */
  keys: Map<string, string>;
  /** Texts that are allowed somewhere: types of nodes, kinds. */
  values: Map<string, string>;
}

type Node = Record<string, unknown>;

function isNode(value: unknown): value is Node {
  return typeof value === "object" && value !== null;
}

/** All keys and texts of `schema`, wherever in a file they are allowed. */
export function wordsOf(schema: unknown): Words {
  const words: Words = { keys: new Map(), values: new Map() };
  collect(schema, words, "");
  return words;
}

function collect(schema: unknown, words: Words, about: string): void {
  if (!isNode(schema)) return;
  if (Array.isArray(schema)) {
    for (const one of schema) collect(one, words, about);
    return;
  }
  const described = typeof schema.description === "string" ? schema.description : about;
  for (const value of [schema.const, ...(Array.isArray(schema.enum) ? schema.enum : [])]) {
    if (typeof value === "string" && !words.values.has(value)) words.values.set(value, described);
  }
  if (isNode(schema.properties)) {
    for (const [key, property] of Object.entries(schema.properties)) {
      const says = isNode(property) && typeof property.description === "string" ? property.description : "";
      if (!words.keys.get(key)) words.keys.set(key, says);
    }
  }
  for (const [key, part] of Object.entries(schema)) {
    if (key === "properties" && isNode(part)) for (const one of Object.values(part)) collect(one, words, "");
    else collect(part, words, described);
  }
}
