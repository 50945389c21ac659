// The page of `virtualrobot console`.
import { render } from "preact";
import { App } from "./app";
import { watch } from "./kernel/watches";
import { look } from "./xr/support";
import "./parts/theme";
import "./style/base.css";
import "./style/frame.css";
import "./style/parts.css";
import "./style/panels.css";
import "./style/finder.css";
import "./style/handling.css";
import "./style/menu.css";

look();
void watch();
render(<App />, document.getElementById("app")!);
