// Sends one command at a time: of the requests that arrive meanwhile, only the
// newest is sent.

const LEAST_MS = 50;

export class LatestOnly {
  private busy = false;
  private asked = false;

  constructor(private readonly send: () => Promise<boolean>) {}

  ask(): void {
    if (this.busy) this.asked = true;
    else void this.run();
  }

  private async run(): Promise<void> {
    this.busy = true;
    const pause = new Promise((done) => setTimeout(done, LEAST_MS));
    const [accepted] = await Promise.all([this.send(), pause]);
    this.busy = false;
    const again = this.asked && accepted;
    this.asked = false;
    if (again) void this.run();
  }
}
